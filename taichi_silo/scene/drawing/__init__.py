"""Drawings: from the entities of a file to the closed line that is a silo's inside, and the bodies in it."""
