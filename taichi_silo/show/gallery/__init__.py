"""A page of all runs of a folder: a frame of each film, key figures, numbers, and links to the films."""
