"""The sand that has left: points that have passed the exit are taken out, and their mass is counted."""

from dataclasses import dataclass, field

import numpy as np

from taichi_silo.mpm.particles import Particles


@dataclass
class Discharge:
    """Takes out the points below a height, and counts what has left; per metre run of the computed part.

    Attributes
    ----------
    particles : the points.
    exit_m : height in the frame of the grid below which a point has left [m].
    mass : that has left [kg/m].
    momentum : that left with it (2,) [N s/m].
    points : number of points that have left.

    """

    particles: Particles
    exit_m: float
    mass: float = 0.0
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(2))
    points: int = 0

    def take_out(self) -> np.ndarray | None:
        """Take out the points that have passed the exit since the last time.

        Returns
        -------
        Which of the points have stayed (n,), None if all have.

        """
        height = self.particles.fields["position"].to_numpy()[: self.particles.active[None], 1]
        gone = height < self.exit_m
        if not gone.any():
            return None
        arrays = self.particles.arrays()
        self.mass += float(arrays["mass"][gone].sum())
        self.momentum = self.momentum + arrays["mass"][gone] @ arrays["velocity"][gone]
        self.points += int(gone.sum())
        self.particles.load({name: values[~gone] for name, values in arrays.items()})
        return ~gone

    def state(self) -> dict:
        """What has left, for `dataclasses.replace` to go on from."""
        return {"mass": self.mass, "momentum": self.momentum, "points": self.points}
