"""What is read from a solver after some steps: impulses on the sand, and sums over the points."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from taichi_silo.mpm.contracts import Law, Wall
from taichi_silo.mpm.field_memory import values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.nodal_impulses import NodalImpulses
from taichi_silo.mpm.partial_sums import PartialSums
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.point_sums import KINDS, PointSums
from taichi_silo.mpm.wall_impulses import Impulses

Record = tuple[np.ndarray, np.ndarray, SimpleNamespace]


class Readings:
    """Fields of a processor, one after the other.

    Parameters
    ----------
    walls, surfaces : walls on grid lines, and the number of the others.
    particles, grid, law : of the solver.

    """

    def __init__(self, walls: tuple[Wall, ...], surfaces: int, particles: Particles, grid: Grid, law: Law):
        self.impulses: Any = Impulses(len(walls) + surfaces, grid)
        self.sums = PointSums(particles, grid, law)

    def record(self) -> Record:
        """Reaction and control (see `Impulses.read_and_reset`), and point sums."""
        return *self.impulses.read_and_reset(), self.sums.read()


class TaskReadings(Readings):
    """One array, which parallel tasks fill: a GPU is waited for once."""

    def __init__(self, walls: tuple[Wall, ...], surfaces: int, particles: Particles, grid: Grid, law: Law):
        self.impulses = NodalImpulses(walls, surfaces, grid, first=len(KINDS))
        self.sums = PartialSums(particles, grid, law, self.impulses.report)

    def record(self) -> Record:
        """As of `Readings`."""
        self.sums.take()
        self.impulses.take()
        report = values(self.impulses.report)
        return *self.impulses.of_report(report), self.sums.of_report(report)
