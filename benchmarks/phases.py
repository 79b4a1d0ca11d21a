"""Each phase of a step, looped alone on one thread: the functions are the solver's own."""

from taichi_silo.mpm.executors import NODES, POINTS, SCATTER, Step
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.store import HALVES, Groups
from taichi_silo.mpm.simd.vectors import arrays_of_eight, compiling_simd, eight
from taichi_silo.mpm.solver import Solver


@ti.data_oriented
class Phases:
    """Kernels over one phase each, of a solver on the vector unit; the state drifts a little, the cost does not."""

    def __init__(self, solver: Solver):
        self.s, self.simd, self.layout = solver, solver.executor, solver.executor.layout
        phases = {phase.over: phase for phase in solver.phases()}
        self.scatter_run, self.nodes_run, self.points_run = (phases[o].run for o in (SCATTER, NODES, POINTS))
        self.eights_run = phases[NODES].eights
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
            given = self.simd.points, self.simd.sums, self.simd.nodal, steps, dt
            if kernel in self.compiled:
                kernel(*given)
            else:
                self.simd.hold()
                with compiling_simd():
                    kernel(*given)
                self.compiled.add(kernel)

        return run

    @ti.kernel
    def scatter(
        self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real
    ):  # fmt: skip
        """Particles to grid."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                step = self._step(store, dt)
                for _step in range(steps):
                    for turn in range(HALVES):
                        store.scatter(self.scatter_run, 0, 1, step, "all", turn)

    @ti.func
    def _step(self, store: ti.template(), dt):
        """What varies from step to step, and what comes before the first."""
        store.begin(0, self.s.grid.rows)
        return Step(dt=dt, gravity=9.81, plate_velocity=0.0, drag=100.0, filling_drag=0.0)

    @ti.kernel
    def grid(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real):
        """Equation of motion of the nodes, on the same sums again and again."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                step = self._step(store, 0.0 * dt)
                for _step in range(steps):
                    for j in range(self.s.grid.rows):
                        self.layout.touched[j] = 1  # the pass empties them, and passes by empty rows
                        for i in range(self.s.grid.columns):
                            sums[j * self.s.grid.columns + i] = eight(1.0)
                        store.row(self.nodes_run, self.eights_run, j, step, "last")

    @ti.kernel
    def gather(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real):
        """Grid to particles: what a point gathers."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                self._step(store, dt)
                for _step in range(steps):
                    for g in range(self.layout.groups):
                        t = store.gather(self.s.grid.velocity, g, 0)
                        total = t[0] + t[1] + t[2] + t[3] + t[4] + t[5] + t[6] + t[7]
                        store.write("path", g, store.read("path", g) + 1e-30 * total)

    @ti.kernel
    def law(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, steps: ti.i32, dt: real):
        """Grid to particles, with motion and law of the points, on the same nodal velocities again and again."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                step = self._step(store, 1e-3 * dt)
                for _step in range(steps):
                    for g in range(self.layout.groups):
                        self.points_run(store, g, 0, step, self.s.grid.velocity)


@ti.data_oriented
class Averages:
    """The means over neighbours alone, of one step."""

    def __init__(self, means):
        self.means, self.add = means, means.add
        self.found = ti.field(real, shape=means.particles.count)

    @ti.kernel
    def steps(self, steps: ti.i32):
        """Compute all means of a field alike everywhere, `steps` times, on one thread."""
        ti.loop_config(serialize=True)
        for _ in range(steps):
            for p in range(self.means.particles.count):
                self.means.give(self, p, ti.cast(1.0, real), 0)
            for run in ti.static(self.means.passes()):
                for j in range(self.means.rows):
                    run(j)
            for p in range(self.means.particles.count):
                self.found[p] = self.means.mean(p)
