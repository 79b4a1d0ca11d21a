"""Who runs the phases of a step: one launch for many steps on the threads of a processor, or one task a phase.

A step is a tuple of `Phase`s (`Solver.phases`), each a function that knows one point, node or row. An executor runs
them, step after step: `Threads` on the fields, each thread over its own points and rows; `tasks.Tasks` on the fields,
one parallel task a phase, as on a GPU; `simd.executor.Simd` on eight points at once. All give the same step. The
functions get as first argument the store that the executor works on: `field_store` says what a store offers.
"""

from typing import Any, NamedTuple

from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.mpm.field_memory import put, values
from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real

# what a phase runs over; SCATTER: points that add to the nodes of their patches; COLLECT: points that add to sums
SCATTER, COLLECT, POINTS, NODES, ROWS = range(5)
SPIN_LIMIT = 500_000_000  # turns of a waiting thread before it gives up (some seconds)
LOST = 32  # slot of `arrivals` that says that one did
MOST_ARRIVALS = 1_000_000_000  # counted before they start anew


class Phase(NamedTuple):
    """A part of a step.

    over : SCATTER, COLLECT or POINTS: run(store, p, t, step, option), t being the number of the thread; NODES:
        run(store, i, j, step, option); ROWS (of nodes): run(store, j, step, option).
    run : the function.
    option : a compile-time constant for it.
    waits : whether it needs what other threads did in the phase before.
    rows : that ROWS runs over; 0: those of the grid.
    eights : what NODES runs on the vector unit for nodes that no wall holds: run(store, first, count, j, step), `count`
        times eight from column `first` on.
    """

    over: int
    run: Any
    option: object = None
    waits: bool = True
    rows: int = 0
    eights: Any = None


@ti.dataclass
class Step:
    """What varies from step to step."""

    dt: real  # [s]
    gravity: real  # [m/s2]
    plate_velocity: real  # of the moving plates [m/s]
    drag: real  # of the noise control, towards the recent motion [1/s]
    filling_drag: real  # towards rest [1/s]


@ti.func
def step_at(number, steps, dt, g0, g1, v0, v1, drag, filling_drag):
    """Step `number` of so many, in which gravity goes linearly from g0 to g1, the plate velocity from v0 to v1."""
    part = (number + 0.5) / steps
    gravity, velocity = g0 + part * (g1 - g0), v0 + part * (v1 - v0)
    return Step(dt=dt, gravity=gravity, plate_velocity=velocity, drag=drag, filling_drag=filling_drag)


@ti.data_oriented
class Barrier:
    """Where the threads of one launch wait for each other.

    It counts the arrivals of all threads; the host hands each launch the number that were counted before it.
    """

    def __init__(self, threads: int):
        self.threads = threads
        self.arrivals = ti.field(ti.i32, shape=64)
        self.passed = 0

    def reserve(self, waits: int) -> int:
        """Arrivals before a launch in which each thread waits so many times."""
        if self.passed > MOST_ARRIVALS:
            put(self.arrivals, 0)
            self.passed = 0
        before = self.passed
        self.passed += waits * self.threads
        return before

    def check(self) -> None:
        """Raise RunFailed if a thread waited in vain for the others."""
        if self.threads > 1 and values(self.arrivals)[LOST]:
            raise RunFailed("because the threads of a step lost each other; use fewer on a machine this busy")

    @ti.func
    def wait(self, before, number):
        """Wait until all threads have come here for the `number`th time (0, 1, ...) in a launch."""
        if ti.static(self.threads > 1):
            enough = before + (number + 1) * self.threads
            ti.atomic_add(self.arrivals[0], 1)
            turns = 0
            while ti.atomic_max(self.arrivals[0], -1) < enough and turns < SPIN_LIMIT and self.arrivals[LOST] == 0:
                turns += 1  # the maximum with -1 is an atomic load
            if turns >= SPIN_LIMIT:
                self.arrivals[LOST] = 1


@ti.data_oriented
class PhaseLoop:
    """All steps of one thread of a launch: its points, its rows of nodes, and where it waits for the others."""

    def __init__(self, phases: tuple[Phase, ...], grid: Grid, threads: int, turns: int = 1):
        """`turns`: in which points add to nodes, those of one turn and several threads to different ones."""
        self.grid, self.threads, self.turns, self.barrier = grid, threads, turns, Barrier(threads)
        begins = [int(number > 0 and phase.waits) for number, phase in enumerate(phases)]
        waits = [
            begin + (turns - 1 if phase.over in (SCATTER, COLLECT) else 0)
            for begin, phase in zip(begins, phases, strict=True)
        ]
        self.waits = sum(waits)  # in a step
        self.phases = tuple(
            (sum(waits[:n]), begins[n], *phase[:3], phase.rows or grid.rows, phase.eights)
            for n, phase in enumerate(phases)
        )

    @ti.func
    def steps(self, store: ti.template(), t, done, count, steps, dt, g0, g1, v0, v1, drag, filling_drag, passed):
        """Steps `done` to `done + count` of so many on thread t."""
        first, last = store.points_of(t, self.threads)
        low, high = t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads
        store.begin(low, high)
        for number in range(count):
            step = step_at(done + number, steps, dt, g0, g1, v0, v1, drag, filling_drag)
            for before, waits, over, run, option, rows, eights in ti.static(self.phases):
                if ti.static(waits):
                    self.barrier.wait(passed, number * self.waits + before)
                if ti.static(over in (SCATTER, COLLECT)):
                    for turn in range(self.turns):
                        if turn > 0:
                            self.barrier.wait(passed, number * self.waits + before + waits + turn - 1)
                        store.scatter(run, t, self.threads, step, option, turn)
                elif ti.static(over == POINTS):
                    for p in range(first, last):
                        run(store, p, t, step, option)
                elif ti.static(over == NODES):
                    for j in range(low, high):
                        store.row(run, eights, j, step, option)
                else:
                    for j in range(t * rows // self.threads, (t + 1) * rows // self.threads):
                        run(store, j, step, option)
            self.grid.follow(t, step)


class Executor:
    """What a solver holds: runs the phases for some steps."""

    threads = 1  # that share a step

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Do steps `done` to `done + count` of a schedule of `steps` (see `Solver.advance`)."""
        raise NotImplementedError

    def check(self) -> None:
        """Raise RunFailed if threads lost each other."""

    def speed(self) -> float | None:
        """Greatest speed of a point after the last launch [m/s], if it is known; None: points may have changed."""
        return None

    def hand_back(self) -> None:
        """Have the fields of the points hold the state; steps may leave it elsewhere."""

    def rest(self) -> None:
        """Hold nothing but the fields, and no memory beside them, until the next launch."""

    def lend(self) -> None:
        """Let somebody change the fields of the points: the state is taken over from them once more."""

    def state(self) -> dict | None:
        """What outlives a launch beside the fields of points and nodes, for a checkpoint; None if nothing does."""
        return None

    def restore(self, state: dict | None) -> None:
        """Go on from fields that were loaded, and from what `state` gave, if there is any."""


@ti.data_oriented
class Threads(Executor):
    """Plain loops on the threads of a processor, each with its own points, rows and copy of the sums."""

    def __init__(self, phases: tuple[Phase, ...], store: Fields):
        self.threads, self.store, self.alone = runtime.threads(), store, runtime.alone()
        if store.grid.copies != self.threads:
            raise ValueError(f"grid has {store.grid.copies} copies of its sums; {self.threads} threads need as many")
        self.loop = PhaseLoop(phases, store.grid, self.threads)

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """One launch for all steps."""
        self._steps(done, count, steps, dt, *schedule, self.loop.barrier.reserve(count * self.loop.waits))

    def check(self) -> None:
        """See `Barrier`."""
        self.loop.barrier.check()

    @ti.kernel
    def _steps(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        drag: real, filling_drag: real, passed: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1, serialize=self.alone)
        for t in range(self.loop.threads):
            self.loop.steps(self.store, t, done, count, steps, dt, g0, g1, v0, v1, drag, filling_drag, passed)
