"""The sand that has left: what has passed the plane of an opening is counted, and soon after taken out."""

from dataclasses import dataclass, field

import numpy as np

from taichi_silo.mpm.particles import Particles
from taichi_silo.scene.outlets import Opening


@dataclass
class Discharge:
    """Counts what has passed openings of the floor, at the height 0 of the grid, or of walls; of the computed part.

    A point counts with the share of its size that is beyond the plane, and is taken out when it has passed the exit,
    where hardly anything of it touches a node that sand within can feel; a quarter as far beyond, when it has spread
    beside the opening, where it would lie for ever.

    Attributes
    ----------
    particles : the points.
    exit_m : distance within the plane at which a point is taken out, below 0 if beyond [m].
    openings : in the frame of the grid.
    spacing_m : size of a point [m].
    mass : that was taken out [kg/m].
    momentum : that went with it (2,) [N s/m].
    points : number of points that were taken out.
    passing : mass that has passed a plane and is still there [kg/m].
    noted : how much had passed when it was last noted that sand flows [kg/m].
    masses, passing_each : `mass` and `passing` of each opening (openings,) [kg/m].
    closed : whether each gate was closed when it was last told (openings,).

    """

    particles: Particles
    exit_m: float
    openings: tuple[Opening, ...]
    spacing_m: float
    mass: float = 0.0
    momentum: np.ndarray = field(default_factory=lambda: np.zeros(2))
    points: int = 0
    passing: float = 0.0
    noted: float = 0.0
    masses: np.ndarray = field(default_factory=lambda: np.zeros(0))
    passing_each: np.ndarray = field(default_factory=lambda: np.zeros(0))
    closed: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))

    def __post_init__(self):
        count = len(self.openings)
        self.masses, self.passing_each = np.resize(self.masses, count), np.resize(self.passing_each, count)
        self.closed = self.closed if len(self.closed) else np.ones(count, bool)
        if count == 1:  # a state of an earlier version has no masses of its own
            self.masses, self.passing_each = np.array([self.mass]), np.array([self.passing])

    @property
    def passed(self) -> float:
        """Mass that has passed a plane [kg/m]."""
        return self.mass + self.passing

    @property
    def passed_each(self) -> np.ndarray:
        """Mass that has passed the plane of each opening (openings,) [kg/m]."""
        return self.masses + self.passing_each

    def flows(self, least_kg_per_m: float) -> bool:
        """Whether as much as this has passed since that was last noted, which is then noted anew."""
        flowing = self.passed >= self.noted + least_kg_per_m
        if flowing:
            self.noted = self.passed
        return flowing

    def take_out(self) -> np.ndarray | None:
        """Count what has passed, and take out the points that have passed an exit, since the last time.

        Returns
        -------
        Which of the points have stayed (n,), None if all have.

        """
        place, d = self.particles.present("position"), self.spacing_m
        by = np.full(len(place), -1, np.int16)  # by which opening a point has gone
        self.passing, self.passing_each = 0.0, np.zeros(len(self.openings))
        for wall in dict.fromkeys(one.wall for one in self.openings):
            numbers = [k for k, one in enumerate(self.openings) if one.wall == wall]
            within, along = self._within(numbers[0], place)
            before = np.zeros(len(place), bool)
            for k in numbers:
                before |= self._before(k, along)
            gone = (by < 0) & (within < np.where(before, self.exit_m, 0.25 * self.exit_m))
            partly = before & (within < 0.5 * d) & ~gone & (by < 0)
            by[gone] = self._nearest(numbers, along[gone])
            if partly.any():
                shares = np.minimum(0.5 - within[partly] / d, 1.0)
                masses = self.particles.array("mass")[partly]
                self.passing += float(masses @ shares)
                np.add.at(self.passing_each, self._nearest(numbers, along[partly]), masses * shares)
        return self._take(by)

    def shut(self, closed: np.ndarray) -> np.ndarray | None:
        """Take out what is beyond gates that have been closed since the last time: they cut the stream.

        Returns
        -------
        As `take_out`.

        """
        shut, self.closed = closed & ~self.closed, closed
        if not shut.any():
            return None
        place = self.particles.present("position")
        by = np.full(len(place), -1, np.int16)
        for k in np.flatnonzero(shut).tolist():
            within, along = self._within(k, place)
            by[(within < 0.0) & self._before(k, along)] = k
        return self._take(by)

    def _within(self, k: int, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far points lie within the plane of an opening, and their places along it (n,) [m]."""
        x, y = place.T
        one = self.openings[k]
        return {"floor": (y, x), "left": (x - one.at_m, y), "right": (one.at_m - x, y)}[one.wall]

    def _before(self, k: int, along: np.ndarray) -> np.ndarray:
        """Whether points lie before or beyond an opening, not beside it."""
        one = self.openings[k]
        return (along > one.low - self.spacing_m) & (along < one.high + self.spacing_m)

    def _nearest(self, numbers: list[int], along: np.ndarray) -> np.ndarray:
        """Which of some openings of a wall is nearest to places along it."""
        edges = np.array([(self.openings[k].low, self.openings[k].high) for k in numbers])
        away = np.maximum(edges[:, :1] - along, along - edges[:, 1:])
        return np.array(numbers)[np.argmin(away, axis=0)]

    def _take(self, by: np.ndarray) -> np.ndarray | None:
        """Take out the points that have gone by some opening (n,), -1 for none; which have stayed (n,)."""
        gone = by >= 0
        if not gone.any():
            return None
        mass, velocity = (self.particles.present(name)[gone] for name in ("mass", "velocity"))
        self.mass += float(mass.sum())
        self.masses = self.masses + np.bincount(by[gone], mass, minlength=len(self.openings))
        self.momentum = self.momentum + mass @ velocity
        self.points += int(gone.sum())
        self.particles.keep(~gone)
        return ~gone

    def state(self) -> dict:
        """What has left, for `dataclasses.replace` to go on from."""
        names = ("mass", "momentum", "points", "passing", "noted")
        several = ("masses", "passing_each", "closed") if len(self.openings) > 1 else ("closed",)
        return {name: getattr(self, name) for name in (*names, *several)}
