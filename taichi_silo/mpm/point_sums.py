"""Sums and extremes over the points: what observers, guards and the choice of the time step ask for."""

import math
from types import SimpleNamespace

import numpy as np

from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.field_memory import values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.several import stiffness as stiffness_of
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.tensors import trace

BELOW = 1.5  # cells below the floor to which sand that has passed an opening may fall
# what is found, and how it is had from the points: see `PointSums.read`
SUM, LEAST, MOST = range(3)
KINDS = {
    "kinetic_energy": SUM, "momentum": SUM, "transit": LEAST, "void_ratio_low": LEAST, "separated": SUM, "strays": SUM,
    "speed": MOST, "void_ratio_high": MOST, "height": SUM, "stored": SUM,
}  # fmt: skip
COUNTS = ("separated", "strays")
FAR = 1e30  # the least of no points


@ti.data_oriented
class PointSums:
    """One pass over the points, one after the other."""

    def __init__(self, particles: Particles, grid: Grid, law: Law):
        self.particles, self.grid, self.law = particles, grid, law
        self.found = ti.field(real, shape=len(KINDS))

    def read(self) -> SimpleNamespace:
        """What the points say now.

        Returns
        -------
        kinetic_energy [J/m], momentum (vertical) [kg m/s /m], transit: least h / (c + |v|) [s], void_ratio_low above
        the floor, separated: points that carry no stress, strays: points outside the grid or not finite, speed:
        greatest [m/s], void_ratio_high, height: sum of mass times height above the floor [kg m/m], stored: sum of
        volume times stress squared over twice the stiffness, the energy that sand gives back at most about once [J/m].

        """
        self.take()
        return self.named(values(self.found))

    @staticmethod
    def named(numbers: np.ndarray) -> SimpleNamespace:
        """Numbers in the order of KINDS by their names."""
        named = dict(zip(KINDS, numbers, strict=True))
        return SimpleNamespace(**named | {name: int(named[name]) for name in COUNTS})

    def speed(self) -> float:
        """Greatest speed [m/s] alone."""
        return math.sqrt(self._greatest_squared_speed())

    @ti.kernel
    def _greatest_squared_speed(self) -> real:
        greatest = ti.cast(0.0, real)
        ti.loop_config(serialize=True)
        for p in range(self.particles.active[None]):
            ti.atomic_max(greatest, self.particles.velocity[p].norm_sqr())
        return greatest

    @ti.func
    def of_point(self, p):
        """What point p adds to the sums and extremes, in the order of KINDS."""
        v, x, s = self.particles.velocity[p], self.particles.position[p], self.particles.stress[p]
        m, volume = self.particles.mass[p], self.particles.volume[p]
        e = volume * self.law.grain_density / m - 1.0
        speed = v.norm()
        stiffness = stiffness_of(self.law, self.particles, p, (s[0], s[1], s[2], s[3]), e)
        c = ti.sqrt(stiffness * (1.0 + e) / self.law.grain_density)
        transit = ti.min(self.grid.cell_size, self.grid.cell_height(0)) / (c + speed)
        packed = e
        if x[1] < 0.0:  # the gate packs what has passed the floor as it likes
            packed = FAR
        squared = s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2.0 * s[3] * s[3]
        separated, stray = 0.0, 0.0
        if -trace((s[0], s[1], s[2], s[3])) <= 3.0 * self.law.rest_stress * (1.0 + 1e-9):
            separated = 1.0
        h, up = self.grid.cell_size, self.grid.cell_height(0)
        beside = BELOW if ti.static(self.grid.open_sides) else 1.0
        across = self.grid.periodic or (x[0] > -beside * h and x[0] < (self.grid.columns - 5 + beside) * h)
        inside = across and x[1] > -BELOW * up and x[1] < (self.grid.rows - 4) * up
        finite = trace((s[0], s[1], s[2], s[3])) + speed < 1e300
        if not (inside and finite):
            stray = 1.0
        return (
            0.5 * m * speed * speed, m * v[1], transit, packed, separated, stray, speed, e, m * x[1],
            0.5 * volume * squared / stiffness,
        )  # fmt: skip

    @ti.kernel
    def take(self):
        """Find them."""
        for _ in range(1):
            for n, kind in ti.static(enumerate(KINDS.values())):
                self.found[n] = nothing(kind)
        ti.loop_config(serialize=True)  # sums in a fixed order, so that runs repeat themselves
        for p in range(self.particles.active[None]):
            values = self.of_point(p)
            for n, kind in ti.static(enumerate(KINDS.values())):
                self.found[n] = joined(kind, self.found[n], values[n])


@ti.func
def nothing(kind: ti.template()):
    """What no points give."""
    return ti.cast(FAR if ti.static(kind == LEAST) else 0.0, real)


@ti.func
def joined(kind: ti.template(), one, other):
    """The sum, the least or the most of two."""
    result = one + other
    if ti.static(kind == LEAST):
        result = ti.min(one, other)
    elif ti.static(kind == MOST):
        result = ti.max(one, other)
    return result
