"""Accuracy against cost: what is varied, runs, errors, and the Pareto front of what is worth its cost."""
