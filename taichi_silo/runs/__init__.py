"""A run and its folder: session, observers, alarms, checkpoints, and the reader of what is left."""
