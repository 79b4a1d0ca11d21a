"""Sums and extremes over the points by parallel tasks."""

from types import SimpleNamespace

import numpy as np

from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.field_memory import values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.point_sums import KINDS, PointSums, joined, nothing
from taichi_silo.mpm.runtime import real

PARTS = 64  # of which the points' sums are made, each of as many parts


@ti.data_oriented
class PartialSums(PointSums):
    """Point sums as three parallel tasks: of parts of the points, of parts of those, of all; always in the same order.

    Parameters
    ----------
    report : a field whose first entries are the result.

    """

    def __init__(self, particles: Particles, grid: Grid, law: Law, report: ti.Field):
        super().__init__(particles, grid, law)
        self.found, self.parts = report, ti.field(real, shape=(len(KINDS), PARTS * PARTS))

    def read(self) -> SimpleNamespace:
        """As of `PointSums`."""
        self.take()
        return self.of_report(values(self.found))

    def of_report(self, report: np.ndarray) -> SimpleNamespace:
        """The result, from the whole report."""
        return self.named(report[: len(KINDS)])

    def speed(self) -> float:
        """Greatest speed [m/s]."""
        return self.read().speed

    @ti.kernel
    def take(self):
        """Put them into the report."""
        for part in range(PARTS * PARTS):
            for n, kind in ti.static(enumerate(KINDS.values())):
                self.parts[n, part] = nothing(kind)
            for number in range((self.particles.count - 1) // (PARTS * PARTS) + 1):
                p = number * PARTS * PARTS + part
                if p < self.particles.active[None]:
                    values = self.of_point(self.particles, p)
                    for n, kind in ti.static(enumerate(KINDS.values())):
                        self.parts[n, part] = joined(kind, self.parts[n, part], values[n])
        for part in range(PARTS):
            for n, kind in ti.static(enumerate(KINDS.values())):
                for other in range(1, PARTS):
                    self.parts[n, part] = joined(kind, self.parts[n, part], self.parts[n, other * PARTS + part])
        for _ in range(1):
            for n, kind in ti.static(enumerate(KINDS.values())):
                self.found[n] = self.parts[n, 0]
                for part in range(1, PARTS):
                    self.found[n] = joined(kind, self.found[n], self.parts[n, part])
