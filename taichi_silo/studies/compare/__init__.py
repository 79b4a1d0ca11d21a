"""Runs side by side: differences between them, from theory, from the paper, and from a user's measurements."""
