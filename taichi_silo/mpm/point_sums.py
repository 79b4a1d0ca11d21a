"""Sums and extremes over the points: what observers, guards and the choice of the time step ask for."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np

from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.field_memory import values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.several import stiffness as stiffness_of
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.lane_maths import alike, greatest, larger, smaller, total
from taichi_silo.mpm.simd.vectors import LANES, eight
from taichi_silo.mpm.tensors import trace

BELOW = 1.5  # cells below the floor to which sand that has passed an opening may fall
# what is found, and how it is had from the points: see `PointSums.read`
SUM, LEAST, MOST, COUNT = range(4)
KINDS = {
    "kinetic_energy": SUM, "momentum": SUM, "transit": LEAST, "void_ratio_low": LEAST, "separated": COUNT,
    "strays": COUNT, "speed": MOST, "void_ratio_high": MOST, "height": SUM, "stored": SUM,
}  # fmt: skip
FAR = 1e30  # the least of no points


@ti.data_oriented
class PointSums:
    """One pass over the points, one after the other, or where the vector unit holds them, over groups of eight.

    `lanes` is the executor that holds them there (`simd.executor`), which then takes them.
    """

    def __init__(self, particles: Particles, grid: Grid, law: Law):
        self.particles, self.grid, self.law = particles, grid, law
        self.found = ti.field(real, shape=len(KINDS))
        self.lanes: Any = None

    def read(self) -> SimpleNamespace:
        """What the points say now.

        Returns
        -------
        kinetic_energy [J/m], momentum (vertical) [kg m/s /m], transit: least h / (c + |v|) [s], void_ratio_low above
        the floor, separated: points that carry no stress, strays: points outside the grid or not finite, speed:
        greatest [m/s], void_ratio_high, height: sum of mass times height above the floor [kg m/m], stored: sum of
        volume times stress squared over twice the stiffness, the energy that sand gives back at most about once [J/m].

        """
        if self.lanes:
            self.lanes.take_sums()
        else:
            self.take()
        return self.named(values(self.found))

    @staticmethod
    def named(numbers: np.ndarray) -> SimpleNamespace:
        """Numbers in the order of KINDS by their names."""
        named = dict(zip(KINDS, numbers, strict=True))
        return SimpleNamespace(**named | {name: int(named[name]) for name, kind in KINDS.items() if kind == COUNT})

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
    def of_point(self, points: ti.template(), p):
        """What point p adds to the sums and extremes, in the order of KINDS: numbers, or eights of a group p.

        `points` is where fields are read, the particles or a store.
        """
        vx, vy = points.read("velocity", p)
        x, y = points.read("position", p)
        s0, s1, s2, s3 = points.read("stress", p)
        m, volume = points.read("mass", p), points.read("volume", p)
        e = volume * self.law.grain_density / m - 1.0
        speed = ti.sqrt(vx * vx + vy * vy)
        stiffness = stiffness_of(self.law, points, p, (s0, s1, s2, s3), e)
        c = ti.sqrt(stiffness * (1.0 + e) / self.law.grain_density)
        h, up = self.grid.cell_size, self.grid.cell_height(0)
        transit = ti.min(h, up) / (c + speed)
        # the gate packs what has passed the floor as it likes
        packed = ti.select(y < 0.0, alike(FAR, e), e)
        squared = s0 * s0 + s1 * s1 + s2 * s2 + 2.0 * s3 * s3
        none, one = alike(0.0, e), alike(1.0, e)
        tr = trace((s0, s1, s2, s3))
        separated = ti.select(tr >= -3.0 * self.law.rest_stress * (1.0 + 1e-9), one, none)
        beside = BELOW if ti.static(self.grid.open_sides) else 1.0
        stray = ti.select(y > -BELOW * up, none, one)
        stray = ti.select(y < (self.grid.rows - 4) * up, stray, one)
        stray = ti.select(tr + speed < 1e300, stray, one)  # not so where one is no number
        if ti.static(not self.grid.periodic):
            stray = ti.select(x > -beside * h, stray, one)
            stray = ti.select(x < (self.grid.columns - 5 + beside) * h, stray, one)
        return (
            0.5 * m * speed * speed, m * vy, transit, packed, separated, stray, speed, e, m * y,
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
            values = self.of_point(self.particles, p)
            for n, kind in ti.static(enumerate(KINDS.values())):
                self.found[n] = joined(kind, self.found[n], values[n])

    @ti.func
    def take_groups(self, store: ti.template()):
        """Find them in the groups of a store, whose sums of nodes are lent for it."""
        active = self.particles.active[None]
        zero = ti.min(active, 0)  # known at run time only: of entry n alone Taichi takes the first value in all rounds
        for n, kind in ti.static(enumerate(KINDS.values())):
            store.sums[n + zero] = eight(nothing(kind))
        for g in range((active + LANES - 1) // LANES):
            values = self.of_point(store, g)
            there = store.there(g)
            for n, kind in ti.static(enumerate(KINDS.values())):
                one = ti.select(there, values[n], eight(nothing(kind)))
                store.sums[n + zero] = joined(kind, store.sums[n + zero], one)
        for n, kind in ti.static(enumerate(KINDS.values())):
            lanes = store.sums[n + zero]
            if ti.static(kind == LEAST):
                self.found[n] = 0.0 - greatest(0.0 - lanes)
            elif ti.static(kind == MOST):
                self.found[n] = greatest(lanes)
            else:
                self.found[n] = total(lanes)
            store.sums[n + zero] = eight(0.0)


@ti.func
def nothing(kind: ti.template()):
    """What no points give."""
    return ti.cast(FAR if ti.static(kind == LEAST) else 0.0, real)


@ti.func
def joined(kind: ti.template(), one, other):
    """The sum, the least or the most of two."""
    result = one + other
    if ti.static(kind == LEAST):
        result = smaller(other, one)
    elif ti.static(kind == MOST):
        result = larger(other, one)
    return result
