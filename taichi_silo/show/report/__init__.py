"""A run as one page for people: what was computed, what came out, how far to trust it."""
