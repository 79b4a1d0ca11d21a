"""The steps of a solver on groups of eight points."""

import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Any

from taichi_silo.mpm import runtime
from taichi_silo.mpm.executors import Executor, Phase, PhaseLoop
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.own_cores import OwnCores
from taichi_silo.mpm.pages import give_back, give_back_freed, in_large_pages
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.lane_maths import greatest, larger
from taichi_silo.mpm.simd.store import HALVES, Groups, Layout
from taichi_silo.mpm.simd.strips import Strips
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight, compiling_simd, eight

LIGHT = 2048  # groups that are loaded and stored by one thread, sooner than others have begun
LARGE = 1 << 25  # bytes of the arrays, from which on it is worth the time to hand them back between steps
NOTHING = 1e-200  # of a point's mass and volume: what fills up the last group


def hindrance(solver: Any) -> str:
    """Why the steps of a solver cannot run on the vector unit; empty if they can."""
    if not runtime.is_cpu():
        return "it runs on a GPU"
    if real != ti.f64:
        return "it does not compute in f64"
    if solver.stress_update != "last":
        return f"its stress update is '{solver.stress_update}'"
    if solver.filter.ACTIVE and not solver.filter.BETWEEN_LAUNCHES:
        return "it filters stresses"
    if solver.transfer.SECOND_TRANSFER or solver.transfer.GRADIENT != "none":
        return f"its transfer is {solver.transfer}"
    if solver.grid.periodic:
        return "its grid is periodic"
    return ""


@ti.data_oriented
class Simd(Executor):
    """Runs phases over groups of eight points (`executors` says what an executor is, `store.Layout` its arrays).

    From one launch to the next the state stays in the arrays; `hand_back` brings it to the fields.
    """

    def __init__(self, phases: tuple[Phase, ...], solver: Any):
        self.particles, self.grid, self.shape = particles, grid, shape = solver.particles, solver.grid, solver.shape
        averaging = solver.averaging
        self.threads, self.alone = runtime.threads(), runtime.alone()
        self.loop = PhaseLoop(phases, grid, self.threads, turns=HALVES)
        walls = None if solver.surfaces.ACTIVE else solver.walls
        self.layout = Layout(particles, grid, shape, solver.surroundings, averaging.KEPT, walls)
        self.points = runtime.array(eight, self.layout.groups * self.layout.record)
        self.sums, self.nodal = (runtime.array(eight, grid.nodes) for _ in range(2))
        self.arrays = self.points, self.sums, self.nodal
        numbers = self.layout.groups * self.layout.record + 2 * grid.nodes
        self.large = 8 * LANES * numbers > LARGE
        if self.large:
            in_large_pages(*self.arrays)
            give_back_freed()
        self.strips = Strips(self.layout, averaging.reach_m)
        self.light = self.alone or self.layout.groups < LIGHT
        self.compiled: set[str] = set()
        self.own_cores = OwnCores(self.threads)
        self.fastest = (-1, 0.0)  # revision of the particles, and greatest speed [m/s]
        self.holds = -1  # revision of the particles whose state the store has
        self.stale = False  # whether the fields have an earlier one
        self.sums_of_points = solver.sums
        solver.sums.lanes = self
        solver.filter.work_on(self)

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Sort, take the state over from the fields if the store has it not, and do all steps in one launch."""
        if not self.strips.wear(count, dt, schedule):
            self._sort()
        self.hold()
        given = *self.arrays, done, count, steps, dt, *schedule, self.loop.barrier.reserve(count * self.loop.waits)
        with self.own_cores.of_launch(), self._compiling("steps"):
            squared = self._steps(*given)
        self.fastest, self.stale = (self.particles.revision, math.sqrt(abs(squared))), True
        if squared < 0.0:
            self.strips.outdate()

    def hand_back(self) -> None:
        """Bring the state to the fields, unless they have it, or a state that was loaded since."""
        if self.stale and self.holds == self.particles.revision:
            self._store(self.points)
        self.stale = False

    def lend(self) -> None:
        """Let somebody use the arrays and change the fields: the state is taken over from them once more."""
        self.holds = -1

    def rest(self) -> None:
        """Hand the state back, and the memory of large arrays: two thirds of all that a silo takes in its steps."""
        self.hand_back()
        self.lend()
        if self.large:
            give_back(*self.arrays)

    def change(self, function: Callable[..., None]) -> None:
        """Let a function of the arrays (points, sums, nodal) change the points; it leaves sums and nodal 0."""
        self.hold()
        with self._compiling(function.__name__):
            function(*self.arrays)
        self.stale = True

    def take_sums(self) -> None:
        """Have the sums over the points taken (see `PointSums`)."""
        self.hold()
        with self._compiling("sums"):
            self._sums(*self.arrays)

    def hold(self) -> None:
        """Have the state in the store."""
        if self.holds != self.particles.revision:
            if self.strips.revision != self.particles.revision:
                self._sort()
            self._load(self.points, self.nodal)
            self.holds = self.particles.revision

    def _sort(self) -> None:
        """Put the points in the order of their cells; the fields hold the state then."""
        self.rest()
        self.strips.sort()

    @contextlib.contextmanager
    def _compiling(self, name: str) -> Iterator[None]:
        """Within, a kernel may be compiled that runs for the first time."""
        if name in self.compiled:
            yield
        else:
            with compiling_simd():
                yield
            self.compiled.add(name)

    def check(self) -> None:
        """See `Barrier`."""
        self.loop.barrier.check()

    def speed(self) -> float | None:
        """Greatest speed of a point [m/s], if no other points were loaded since the last launch."""
        revision, speed = self.fastest
        return speed if revision == self.particles.revision else None

    def state(self) -> dict | None:
        """What outlives a launch beside the fields: the order of the points, and when they were sorted."""
        return self.strips.state()

    def restore(self, state: dict | None) -> None:
        """Go on from fields that were loaded, and from a state (`Strips.restore`)."""
        self.fastest = (-1, 0.0)
        self.holds, self.stale = -1, False
        self.strips.restore(state)

    @ti.kernel
    def _load(self, points: arrays_of_eight, nodal: arrays_of_eight):
        ti.loop_config(serialize=self.light)
        for g in range(self.layout.groups):
            for lane in range(LANES):
                p, scale = self.layout.order[g * LANES + lane], ti.cast(1.0, real)
                if p >= self.particles.active[None]:
                    p, scale = self.layout.order[ti.max(self.particles.active[None] - 1, 0)], NOTHING
                for name in ti.static(self.particles.names):
                    k = g * self.layout.record + ti.static(self.layout.begins[name])
                    width = ti.static(self.particles.WIDTHS.get(name, 1))
                    if ti.static(name in ("mass", "volume")):
                        points[k][lane] = scale * ti.static(self.particles.fields[name])[p]
                    elif ti.static(width == 1):
                        points[k][lane] = ti.static(self.particles.fields[name])[p]
                    else:
                        for c in ti.static(range(width)):
                            points[k + c][lane] = ti.static(self.particles.fields[name])[p][c]
        ti.loop_config(serialize=self.light)
        for k in range(self.grid.nodes):  # which somebody may have borrowed
            for lane in ti.static(range(LANES)):
                nodal[k][lane] = 0.0

    @ti.kernel
    def _store(self, points: arrays_of_eight):
        ti.loop_config(serialize=self.light)
        for g in range((self.particles.active[None] + LANES - 1) // LANES):
            for lane in range(ti.min(LANES, self.particles.active[None] - g * LANES)):
                p = self.layout.order[g * LANES + lane]
                for name in ti.static(self.particles.names):
                    k = g * self.layout.record + ti.static(self.layout.begins[name])
                    width = ti.static(self.particles.WIDTHS.get(name, 1))
                    if ti.static(width == 1):
                        ti.static(self.particles.fields[name])[p] = points[k][lane]
                    else:
                        for c in ti.static(range(width)):
                            ti.static(self.particles.fields[name])[p][c] = points[k + c][lane]

    @ti.kernel
    def _sums(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight):
        ti.loop_config(serialize=True)  # in a fixed order, so that runs repeat themselves
        for _ in range(1):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                self.sums_of_points.take_groups(store)

    @ti.kernel
    def _steps(
        self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, done: ti.i32, count: ti.i32,
        steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real, drag: real, filling_drag: real,
        passed: ti.i32,
    ) -> real:  # fmt: skip
        """The steps; returns the square of the greatest speed then [m2/s2], less than 0 if strips are crowded."""
        found = ti.cast(0.0, real)
        for store in ti.static([Groups(self.layout, points, sums, nodal)]):  # known while this is compiled
            ti.loop_config(block_dim=1, serialize=self.alone)
            for t in range(self.loop.threads):
                self.loop.steps(store, t, done, count, steps, dt, g0, g1, v0, v1, drag, filling_drag, passed)
            ti.loop_config(serialize=True)
            for _ in range(1):
                found = self._most(store)
                if self.strips.crowded():
                    found = -1e-300 - found
        return found

    @ti.func
    def _most(self, store: ti.template()):
        """Square of the greatest speed of a point."""
        most = eight(0.0)
        for g in range((self.particles.active[None] + LANES - 1) // LANES):
            x, y = store.read("velocity", g)
            most = larger(ti.select(store.there(g), x * x + y * y, eight(0.0)), most)
        return greatest(most)
