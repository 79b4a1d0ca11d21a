"""Files, processes, messages: nothing of mechanics."""
