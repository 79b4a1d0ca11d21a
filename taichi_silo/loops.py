"""The loops over points and nodes: the phases of a step, in one of three ways that give the same result."""

import taichi as ti

from taichi_silo import runtime
from taichi_silo.runtime import real

SPIN_LIMIT = 500_000_000  # turns of a waiting thread before it gives up (some seconds)
LOST = 32  # slot of `arrivals` that says that one did
POINTS, NODES = 0, 1  # what a phase runs over


@ti.dataclass
class Step:
    """What varies from step to step."""

    dt: real  # [s]
    gravity: real  # [m/s2]
    plate_velocity: real  # of the moving plates [m/s]
    filling_drag: real  # [1/s]


@ti.data_oriented
class Loops:
    """Runs `self.phases` over `self.particles` and `self.grid`, step after step.

    A phase is (number, POINTS or NODES, function, option); a function of points takes (p, t, step, option, shared),
    one of nodes (i, j, step, option, shared), t being the thread's number. On one thread and on several, which keep
    their own strips of points and copies of the sums, one launch does many steps; `shared`, as on a GPU, is one launch
    a phase with atomic sums.
    """

    def __init__(self, shared: bool | None):
        self.shared = not runtime.is_cpu() if shared is None else shared
        self.threads = 1 if self.shared else runtime.threads()
        if not self.shared and self.grid.copies != self.threads:
            raise ValueError(f"grid has {self.grid.copies} copies of its sums; {self.threads} threads need as many")
        self.arrivals = ti.field(ti.i32, shape=64)
        self.passed = 0

    @property
    def waits(self) -> int:
        """How often the threads wait for each other in a step."""
        return len(self.phases) - 1

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Steps `done` to `done + count` of a schedule of `steps` (see `Solver.advance`)."""
        if self.shared:
            for number in range(done, done + count):
                self._step_shared(number, steps, dt, *schedule)
        elif self.threads == 1:
            self._steps_alone(done, count, steps, dt, *schedule)
        else:
            if self.passed > 1_000_000_000:
                self.arrivals.fill(0)
                self.passed = 0
            self._steps_together(done, count, steps, dt, *schedule, self.passed)
            self.passed += self.waits * self.threads * count

    def lost(self) -> bool:
        """Whether a thread waited in vain for the others."""
        return self.threads > 1 and bool(self.arrivals[LOST])

    @ti.func
    def _at(self, number, steps, dt, g0, g1, v0, v1, filling_drag):
        part = (number + 0.5) / steps
        return Step(
            dt=dt, gravity=g0 + part * (g1 - g0), plate_velocity=v0 + part * (v1 - v0), filling_drag=filling_drag
        )

    @ti.kernel
    def _step_shared(
        self, number: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real, filling_drag: real
    ):
        for _phase, over, do, option in ti.static(self.phases):
            if ti.static(over == POINTS):
                for p in range(self.particles.active[None]):
                    do(p, 0, self._at(number, steps, dt, g0, g1, v0, v1, filling_drag), option, True)
            else:
                for k in range(self.grid.nodes):
                    j = k // self.grid.columns
                    i = k - j * self.grid.columns
                    do(i, j, self._at(number, steps, dt, g0, g1, v0, v1, filling_drag), option, True)
        for t in range(1):
            self.grid.follow(t, self._at(number, steps, dt, g0, g1, v0, v1, filling_drag))

    @ti.kernel
    def _steps_alone(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real,
    ):  # fmt: skip
        ti.loop_config(serialize=True)
        for number in range(done, done + count):
            step = self._at(number, steps, dt, g0, g1, v0, v1, filling_drag)
            for _phase, over, do, option in ti.static(self.phases):
                if ti.static(over == POINTS):
                    for p in range(self.particles.active[None]):
                        do(p, 0, step, option, False)
                else:
                    for j in range(self.grid.rows):
                        for i in range(self.grid.columns):
                            do(i, j, step, option, False)
            self.grid.follow(0, step)

    @ti.kernel
    def _steps_together(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real, passed: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for t in range(self.threads):
            points = self.particles.active[None]
            first, last = t * points // self.threads, (t + 1) * points // self.threads
            low, high = t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads
            for number in range(count):
                step = self._at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
                arrivals = passed + self.threads * self.waits * number
                for phase, over, do, option in ti.static(self.phases):
                    if ti.static(phase > 0):
                        self._wait(arrivals + phase * self.threads)
                    if ti.static(over == POINTS):
                        for p in range(first, last):
                            do(p, t, step, option, False)
                    else:
                        for j in range(low, high):
                            for i in range(self.grid.columns):
                                do(i, j, step, option, False)
                self.grid.follow(t, step)

    @ti.func
    def _wait(self, arrivals):
        """Wait until all threads have arrived."""
        ti.atomic_add(self.arrivals[0], 1)
        turns = 0
        while ti.atomic_max(self.arrivals[0], -1) < arrivals and turns < SPIN_LIMIT and self.arrivals[LOST] == 0:
            turns += 1  # the maximum with -1 is an atomic load
        if turns >= SPIN_LIMIT:
            self.arrivals[LOST] = 1
