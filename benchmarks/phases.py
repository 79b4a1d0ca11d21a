"""Each phase of a step, looped alone on one thread: the functions are the solver's own."""

import taichi as ti

from taichi_silo.laws.integrate import update
from taichi_silo.loops import Step
from taichi_silo.runtime import real
from taichi_silo.solver import Solver
from taichi_silo.tensors import norm


@ti.data_oriented
class Phases:
    """Kernels over one phase each; the state drifts a little, the cost does not."""

    def __init__(self, solver: Solver):
        self.s = solver
        self.sink = ti.field(real, shape=())

    def all(self):
        """Name of each phase and its loop, called with (steps, dt)."""
        return {
            "particles to grid": self.scatter,
            "grid": self.grid,
            "grid to particles and law": self.gather,
            "law alone": self.law,
        }

    @ti.kernel
    def scatter(self, steps: ti.i32, dt: real):
        """Particles to grid."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            step = Step(dt=dt, gravity=9.81, plate_velocity=0.0, filling_drag=0.0)
            for p in range(self.s.particles.count):
                self.s._scatter(p, 0, step, "all", False)

    @ti.kernel
    def grid(self, steps: ti.i32, dt: real):
        """Equation of motion of the nodes."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for j in range(self.s.grid.rows):
                for i in range(self.s.grid.columns):
                    k = j * self.s.grid.columns + i
                    self.s.grid.mass[k] = 1.0  # the pass empties its sums
                    step = Step(dt=0.0 * dt, gravity=9.81, plate_velocity=0.0, filling_drag=0.0)
                    self.s._integrate(i, j, step, "last", False)

    @ti.kernel
    def gather(self, steps: ti.i32, dt: real):
        """Grid to particles, with the law."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for p in range(self.s.particles.count):
                step = Step(dt=1e-3 * dt, gravity=9.81, plate_velocity=0.0, filling_drag=0.0)
                self.s._gather(p, 0, step, self.s.grid.velocity, False)

    @ti.kernel
    def law(self, steps: ti.i32, dt: real):
        """The law at a constant strain rate."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for p in range(self.s.particles.count):
                s = self.s.particles.stress[p]
                e = self.s.particles.volume[p] * self.s.law.grain_density / self.s.particles.mass[p] - 1.0
                v = self.s.particles.velocity[p]
                D = (1e-6 * v[0], 1e-6 * v[1] - 1e-6, 0.0 * v[0], 1e-6 * v[1])
                h = 0.0 * s
                a, b, c, d, h0, h1, h2, h3, void_ratio = update(
                    self.s.law, (s[0], s[1], s[2], s[3]), (h[0], h[1], h[2], h[3]), e, D, 1e-6 * v[1], norm(D), dt
                )
                self.s.particles.stress[p] = ti.Vector([a, b, c, d])
                self.sink[None] = void_ratio + h0 + h1 + h2 + h3


@ti.data_oriented
class Neighbours:
    """The non-local average alone: all means of one step."""

    def __init__(self, average):
        self.average = average
        self.found = ti.field(real, shape=average.particles.count)

    @ti.kernel
    def means(self, steps: ti.i32):
        """All means, `steps` times, on one thread."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for p in range(self.average.particles.count):
                self.found[p] = self.average.mean(p)
