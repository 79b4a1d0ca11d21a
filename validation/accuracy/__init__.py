"""Accuracy against cost: dials, runs, errors, and the front of what is worth its cost."""
