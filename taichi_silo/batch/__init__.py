"""Many silos at once: scenes from files and variations, a process and a folder for each, one table and one figure."""
