"""The states of a run in files of other programs.

Each format is a module with a function `write(run, target, seen)`.
"""
