"""The sand that has left: what has passed the opening's plane is counted, and soon after taken out."""

from dataclasses import dataclass, field

import numpy as np

from taichi_silo.mpm.particles import Particles


@dataclass
class Discharge:
    """Counts what has passed an opening at the height 0 of the grid; per metre run of the computed part.

    A point counts with the share of its height that is below the plane, and is taken out when it has passed the exit,
    where hardly anything of it touches a node that sand above the plane can feel; a quarter as deep, when it has spread
    beside the opening, where it would lie for ever.

    Attributes
    ----------
    particles : the points.
    exit_m : height in the frame of the grid below which a point is taken out [m].
    opening_m : its edges, in the frame of the grid [m].
    spacing_m : height of a point [m].
    mass : that was taken out [kg/m].
    momentum : that went with it (2,) [N s/m].
    points : number of points that were taken out.
    passing : mass that has passed the plane and is still there [kg/m].
    noted : how much had passed when it was last noted that sand flows [kg/m].

    """

    particles: Particles
    exit_m: float
    opening_m: tuple[float, float]
    spacing_m: float
    mass: float = 0.0
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(2))
    points: int = 0
    passing: float = 0.0
    noted: float = 0.0

    @property
    def passed(self) -> float:
        """Mass that has passed the plane [kg/m]."""
        return self.mass + self.passing

    def flows(self, least_kg_per_m: float) -> bool:
        """Whether as much as this has passed since that was last noted, which is then noted anew."""
        flowing = self.passed >= self.noted + least_kg_per_m
        if flowing:
            self.noted = self.passed
        return flowing

    def take_out(self) -> np.ndarray | None:
        """Count what has passed the plane, and take out the points that have passed the exit, since the last time.

        Returns
        -------
        Which of the points have stayed (n,), None if all have.

        """
        x, height = self.particles.array("position").T
        (left, right), d = self.opening_m, self.spacing_m
        below = (x > left - d) & (x < right + d)
        gone = height < np.where(below, self.exit_m, 0.25 * self.exit_m)
        partly = below & (height < 0.5 * d) & ~gone
        self.passing = 0.0
        if partly.any():
            masses = self.particles.array("mass")[partly]
            self.passing = float(masses @ np.minimum(0.5 - height[partly] / d, 1.0))
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
        names = ("mass", "momentum", "points", "passing", "noted")
        return {name: getattr(self, name) for name in names}
