"""The steps of a solver on groups of eight points; the solver's fields hold the state before and after each launch.

The points are cut into strips, whose number depends on the points, not on the threads: the order of every sum, and
with it every bit of the result, is the same for any number of threads.
"""

import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.executors import Executor, Phase, PhaseLoop
from taichi_silo.mpm.field_memory import present, put, values
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.own_cores import OwnCores
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.lane_maths import greatest, larger
from taichi_silo.mpm.simd.store import HALVES, STRIPS, Groups, Layout
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight, compiling_simd, eight
from taichi_silo.mpm.walls.outlets import OPENED

SORTED_FOR = 0.25  # of a cell: as far as points may move before they are sorted anew
WIDEST = 3  # patch of a point, of its shape or of a filter [nodes]
LIGHT = 2048  # groups that are loaded and stored by one thread, sooner than others have begun
FAR = 1e9  # cells, beyond which no number of a cell is told from another
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
        self.sorted = (-1, 0.0)  # revision of the particles, and how far points may have moved since [cells]
        self.strips = 2  # that the points are cut into
        # rows of cells between points of strips with the same sums: no common node, and a row that either may move
        reach = math.ceil(averaging.reach_m / min(grid.cell_size, grid.first_cell_height))
        self.apart = max(WIDEST + (4 if shape.DOMAIN else 0), reach) + 2
        self.gap = max(0, 2 * (WIDEST - shape.NODES), reach - shape.NODES)  # rows of nodes that must stay between
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
        self._sort(count, dt, schedule)
        if done == 0 or self.holds != self.particles.revision:
            self.load()
        given = *self.arrays, done, count, steps, dt, *schedule, self.loop.barrier.reserve(count * self.loop.waits)
        with self.own_cores.of_launch(), self._compiling("steps"):
            self._steps(*given)
        with self._compiling("look"):
            squared = self._look(*self.arrays)
        self.fastest, self.stale = (self.particles.revision, math.sqrt(abs(squared))), True
        if squared < 0.0:
            self.sorted = (-1, 0.0)

    def hand_back(self) -> None:
        """Bring the state to the fields, unless they have it, or a state that was loaded since."""
        if self.stale and self.holds == self.particles.revision:
            self._store(self.points)
        self.stale = False

    def lend(self) -> None:
        """Let somebody use the arrays and change the fields: the state is taken over from them once more."""
        self.holds = -1

    def change(self, function: Callable[..., None]) -> None:
        """Let a function of the arrays (points, sums, nodal) change the points; it leaves sums and nodal 0."""
        self._hold()
        with self._compiling(function.__name__):
            function(*self.arrays)
        self.stale = True

    def take_sums(self) -> None:
        """Have the sums over the points taken (see `PointSums`)."""
        self._hold()
        with self._compiling("sums"):
            self._sums(*self.arrays)

    def _hold(self) -> None:
        """Have the state in the store."""
        if self.holds != self.particles.revision:
            self._sort(0, 0.0, (0.0,) * 6)
            self.load()

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
        return {"sorted": list(self.sorted), "order": present(self.layout.order), "strips": self.strips}

    def restore(self, state: dict | None) -> None:
        """Go on from fields that were loaded, and from a state; without one the points are sorted before the next step.

        Raises
        ------
        ValueError
            if the order names points that are not there.

        """
        self.sorted = self.fastest = (-1, 0.0)
        self.holds, self.stale = -1, False
        if state:
            if not ((state["order"] >= 0) & (state["order"] <= self.particles.count)).all():
                raise ValueError("the order names points that are not there")
            put(self.layout.order, state["order"])
            if "strips" in state:  # otherwise it is of a version that cut the points elsewhere
                self.sorted = tuple(state["sorted"])
                self._cut(int(state["strips"]))

    def load(self) -> None:
        """Take the state over from the fields."""
        self._load(self.points, self.nodal)
        self.holds = self.particles.revision

    def _sort(self, count: int, dt: float, schedule: tuple[float, ...]) -> None:
        """Put the points in the order of their cells, unless they hardly moved since that was done."""
        revision, moved = self.sorted
        carried = max(abs(v) for v in schedule[2:4]) if min(schedule[2:4]) > OPENED else 0.0
        moved += 2.0 * count * dt * carried / self.grid.cell_size
        moved += count * 1e-4  # if something moves by itself faster than that, the order is not the best
        if revision == self.particles.revision and moved < SORTED_FOR:
            self.sorted = revision, moved
            return
        self.hand_back()
        self.holds = -1
        column, row = self._cells()
        order = np.lexsort((column, row)).astype(np.int32)
        del column
        rows = row[order]
        spare = self.layout.groups * LANES - len(order)
        put(self.layout.order, np.pad(order, (0, spare), constant_values=self.particles.count))
        self.sorted = self.particles.revision, 0.0
        self._cut(next(count for count in (16, 8, 4, 2) if count == 2 or self._stand_apart(rows, count)))

    def _cells(self) -> tuple[np.ndarray, np.ndarray]:
        """Column and row of the cell of each point; all the same where a place is no number."""
        place, found = self.particles.present("position"), []
        if not np.isfinite(place).all():
            return np.zeros(len(place), np.int32), np.zeros(len(place), np.int32)
        heights = self.grid.cell_size, self.grid.first_cell_height * float(values(self.grid.stretch)[0])
        offset = self.shape.half_size if self.shape.NODES == 3 else 0.0
        for axis, size in enumerate(heights):
            # a lattice may lie on the edge of cells: round-off must not tear its rows apart
            cell = place[:, axis] * (1.0 / size)
            cell -= offset
            cell += 1e-9
            found.append(np.floor(cell, out=cell).clip(-FAR, FAR).astype(np.int32))
        return found[0], found[1]

    def _bounds(self, count: int) -> np.ndarray:
        """First group of each of so many strips, and the end of the last."""
        groups = (self.particles.number + LANES - 1) // LANES
        return np.arange(count + 1) * groups // count

    def _stand_apart(self, rows: np.ndarray, count: int) -> bool:
        """Whether strips with one between them are far enough apart, the points being in these rows of cells."""
        ends = self._bounds(count) * LANES
        if (np.diff(ends) == 0).any():
            return False
        first, last = rows[ends[:-1]], rows[np.minimum(ends[1:], len(rows)) - 1]
        return bool((first[2:] - last[:-2] >= self.apart).all())

    @ti.func
    def _crowded(self):
        """Whether strips with the same sums have come closer than a row of nodes and the gap."""
        found = False
        for one in range(STRIPS):
            low, high = self.layout.reach[one, 0], self.layout.reach[one, 1]
            for other in range(one + 1, STRIPS):
                first, last = self.layout.reach[other, 0], self.layout.reach[other, 1]
                both = self.layout.half[one] == self.layout.half[other] and low < high and first < last
                found = found or (both and first <= high + self.gap)
        return found

    def _cut(self, count: int) -> None:
        """Cut the points into so many strips, a power of 2; the others are empty."""
        self.strips = count
        bounds, every = self._bounds(count), STRIPS // count
        slots = np.arange(STRIPS + 1)
        put(self.layout.first, bounds[-(-slots // every)])
        half = slots[:-1] // every % HALVES
        put(self.layout.half, half)

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
    def _look(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight) -> real:
        """Square of the greatest speed of a point [m2/s2], less than 0 if strips are crowded."""
        found = ti.cast(0.0, real)
        ti.loop_config(serialize=True)
        for _ in range(1):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                most = eight(0.0)
                for g in range((self.particles.active[None] + LANES - 1) // LANES):
                    x, y = store.read("velocity", g)
                    most = larger(ti.select(store.there(g), x * x + y * y, eight(0.0)), most)
                found = greatest(most)
            if self._crowded():
                found = -1e-300 - found
        return found

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
    ):  # fmt: skip
        ti.loop_config(block_dim=1, serialize=self.alone)
        for t in range(self.loop.threads):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):  # known while this is compiled
                self.loop.steps(store, t, done, count, steps, dt, g0, g1, v0, v1, drag, filling_drag, passed)
