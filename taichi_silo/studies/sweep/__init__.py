"""Parameter studies: a file says what varies, workers of dask.distributed run it, a table and figures remain."""
