"""Closed-form theories that a simulation is compared with."""
