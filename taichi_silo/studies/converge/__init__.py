"""A scene computed on finer and finer grids, and what its numbers tend to."""
