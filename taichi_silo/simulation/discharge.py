"""The sand that has left: what passes the exit is taken out of the points and kept in the books."""

import numpy as np

from taichi_silo.mpm.particles import Particles


class Ledger:
    """Takes out the points below a height.

    Parameters
    ----------
    particles : the points.
    exit_m : height in the frame of the grid below which a point has left [m].

    """

    def __init__(self, particles: Particles, exit_m: float):
        self.particles, self.exit = particles, exit_m
        self.mass = 0.0  # that has left [kg/m]
        self.momentum = np.zeros(2)  # that left with it [N s/m]
        self.points = 0

    def settle(self) -> np.ndarray | None:
        """Take out what has passed the exit since the last time.

        Returns
        -------
        Which of the points have stayed (n,), None if all have.

        """
        gone = self.particles.position.to_numpy()[: self.particles.active[None], 1] < self.exit
        if not gone.any():
            return None
        arrays = self.particles.arrays()
        self.mass += float(arrays["mass"][gone].sum())
        self.momentum += arrays["mass"][gone] @ arrays["velocity"][gone]
        self.points += int(gone.sum())
        self.particles.load({name: values[~gone] for name, values in arrays.items()})
        return ~gone
