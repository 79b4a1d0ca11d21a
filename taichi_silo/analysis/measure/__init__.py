"""Measurements on the fields of a run."""
