"""Sums and extremes over the points: what observers, guards and the choice of the time step ask for."""

import math
from types import SimpleNamespace

import taichi as ti

from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.tensors import trace

BELOW = 1.5  # cells below the floor to which sand that has passed an opening may fall


@ti.data_oriented
class PointSums:
    """One pass over the points."""

    def __init__(self, particles: Particles, grid: Grid, law: Law, shared: bool):
        self.particles, self.grid, self.law, self.shared = particles, grid, law, shared
        self.found = ti.field(real, shape=10)

    def read(self) -> SimpleNamespace:
        """What the points say now.

        Returns
        -------
        kinetic_energy [J/m], momentum (vertical) [kg m/s /m], transit: least h / (c + |v|) [s], void_ratio_low,
        separated: points that carry no stress, strays: points outside the grid or not finite, speed: greatest [m/s],
        void_ratio_high, height: sum of mass times height above the floor [kg m/m], stored: sum of volume times stress
        squared over twice the stiffness, the energy that sand gives back at most about once [J/m].

        """
        self._take()
        energy, momentum, transit, low, separated, strays, speed, high, height, stored = self.found.to_numpy()
        return SimpleNamespace(
            kinetic_energy=energy, momentum=momentum, transit=transit, void_ratio_low=low, separated=int(separated),
            strays=int(strays), speed=speed, void_ratio_high=high, height=height, stored=stored,
        )  # fmt: skip

    def speed(self) -> float:
        """Greatest speed [m/s] alone."""
        return math.sqrt(self._greatest_squared_speed())

    @ti.kernel
    def _greatest_squared_speed(self) -> real:
        greatest = ti.cast(0.0, real)
        ti.loop_config(serialize=ti.static(not self.shared))
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            ti.atomic_max(greatest, self.particles.velocity[p].norm_sqr())
        return greatest

    @ti.kernel
    def _take(self):
        for _ in range(1):
            self.found[0], self.found[1], self.found[4], self.found[5], self.found[6] = 0.0, 0.0, 0.0, 0.0, 0.0
            self.found[2], self.found[3] = 1e30, 1e30
            self.found[7], self.found[8], self.found[9] = 0.0, 0.0, 0.0
        if ti.static(not self.shared):
            ti.loop_config(serialize=True)  # sums in a fixed order, so that runs repeat themselves
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            v, x, s = self.particles.velocity[p], self.particles.position[p], self.particles.stress[p]
            m, volume = self.particles.mass[p], self.particles.volume[p]
            e = volume * self.law.grain_density / m - 1.0
            speed = v.norm()
            stiffness = self.law.stiffness((s[0], s[1], s[2], s[3]), e)
            c = ti.sqrt(stiffness * (1.0 + e) / self.law.grain_density)
            self.found[0] += 0.5 * m * speed * speed
            self.found[1] += m * v[1]
            ti.atomic_min(self.found[2], ti.min(self.grid.cell_size, self.grid.cell_height(0)) / (c + speed))
            ti.atomic_min(self.found[3], e)
            ti.atomic_max(self.found[7], e)
            self.found[8] += m * x[1]
            squared = s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2.0 * s[3] * s[3]
            self.found[9] += 0.5 * volume * squared / stiffness
            if -trace((s[0], s[1], s[2], s[3])) <= 3.0 * self.law.rest_stress * (1.0 + 1e-9):
                self.found[4] += 1.0
            ti.atomic_max(self.found[6], speed)
            h, up = self.grid.cell_size, self.grid.cell_height(0)
            across = self.grid.periodic or (x[0] > -h and x[0] < (self.grid.columns - 4) * h)
            inside = across and x[1] > -BELOW * up and x[1] < (self.grid.rows - 4) * up
            finite = trace((s[0], s[1], s[2], s[3])) + speed < 1e300
            if not (inside and finite):
                self.found[5] += 1.0
