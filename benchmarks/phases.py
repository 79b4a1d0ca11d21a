"""Each phase of a step, looped alone on one thread: the functions are the solver's own."""

import taichi as ti

from taichi_silo.mpm import runtime
from taichi_silo.mpm.loops import Step
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd import arrays_of_eight
from taichi_silo.mpm.solver import Solver


@ti.data_oriented
class Phases:
    """Kernels over one phase each, on the lanes of a solver; the state drifts a little, the cost does not."""

    def __init__(self, solver: Solver):
        self.s, self.lanes = solver, solver.lanes
        self.groups = solver.particles.groups
        self.compiled = set()

    def all(self):
        """Name of each phase and its loop, called with (steps, dt)."""
        return {
            "particles to grid": self._timed(self.scatter),
            "grid": self._timed(self.grid),
            "grid to particles": self._timed(self.gather),
            "grid to particles, law": self._timed(self.law),
        }

    def _timed(self, kernel):
        def run(steps: int, dt: float) -> None:
            given = self.lanes.points, self.lanes.sums, self.lanes.nodal, steps, dt
            if kernel in self.compiled:
                kernel(*given)
            else:
                self.lanes.load()
                with runtime.compiling_wide():
                    kernel(*given)
                self.compiled.add(kernel)

        return run

    @ti.kernel
    def scatter(
        self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real
    ):  # fmt: skip
        """Particles to grid."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for strip in range(self.lanes.strips):
                begin, end = strip * self.groups // self.lanes.strips, (strip + 1) * self.groups // self.lanes.strips
                self.lanes.scatter(points, sums, strip, begin, end, 0)

    @ti.kernel
    def grid(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real):
        """Equation of motion of the nodes, on the same sums again and again."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            step = Step(dt=0.0 * dt, gravity=9.81, plate_velocity=0.0, filling_drag=0.0)
            for j in range(self.s.grid.rows):
                for i in range(self.s.grid.columns):  # the pass empties them
                    sums[j * self.s.grid.columns + i][0] = 1.0
                self.lanes.integrate_row(sums, nodal, j, step)

    @ti.kernel
    def gather(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real):
        """Grid to particles: what a point takes."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for g in range(self.groups):
                t = self.lanes.gather(points, nodal, g, 0)
                total = t[0] + t[1] + t[2] + t[3] + t[4] + t[5] + t[6] + t[7]
                self.s.particles.write(points, "path", g, self.s.particles.read(points, "path", g) + 1e-30 * total)

    @ti.kernel
    def law(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real):
        """Grid to particles, with motion and law of the points, on the same nodal velocities again and again."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            step = Step(dt=1e-3 * dt, gravity=9.81, plate_velocity=0.0, filling_drag=0.0)
            for g in range(self.groups):
                self.s.update_point(points, g, 0, step, self.lanes.gather(points, nodal, g, 0), True, True)


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
