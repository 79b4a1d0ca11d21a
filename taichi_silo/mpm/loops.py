"""The loops over points and nodes: the phases of a step, in one of three ways that give the same result."""

import taichi as ti

from taichi_silo.mpm import runtime
from taichi_silo.mpm.barrier import Barrier
from taichi_silo.mpm.runtime import real

POINTS, NODES = 0, 1  # what a phase runs over
BURST = 8  # steps in a launch, where each phase is a task of its own: the host's part of a launch is shared


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
    their own strips of points and copies of the sums, one launch does many steps; `shared`, as on a GPU, is one task a
    phase with atomic sums.
    """

    def __init__(self, shared: bool | None):
        self.shared = not runtime.is_cpu() if shared is None else shared
        self.threads = 1 if self.shared else runtime.threads()
        if not self.shared and self.grid.copies != self.threads:
            raise ValueError(f"grid has {self.grid.copies} copies of its sums; {self.threads} threads need as many")
        self.barrier, self.lanes = Barrier(self.threads), None

    @property
    def waits(self) -> int:
        """How often the threads wait for each other in a step."""
        return len(self.phases) - 1

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Steps `done` to `done + count` of a schedule of `steps` (see `Solver.advance`)."""
        if self.lanes:
            self.lanes.run(done, count, steps, dt, *schedule)
        elif self.shared:
            number = done
            while number < done + count:
                together = BURST if done + count - number >= BURST else 1
                self._steps_shared(number, together, steps, dt, *schedule)
                number += together
        elif self.threads == 1:
            self._steps_alone(done, count, steps, dt, *schedule)
        else:
            self._steps_together(done, count, steps, dt, *schedule, self.barrier.reserve(count * self.waits))

    @ti.func
    def at(self, number, steps, dt, g0, g1, v0, v1, filling_drag):
        """Step `number` of a schedule that goes from g0, v0 to g1, v1 in so many steps."""
        part = (number + 0.5) / steps
        return Step(
            dt=dt, gravity=g0 + part * (g1 - g0), plate_velocity=v0 + part * (v1 - v0), filling_drag=filling_drag
        )

    @ti.kernel
    def _steps_shared(
        self, done: ti.i32, count: ti.template(), steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real,
    ):  # fmt: skip
        for number in ti.static(range(count)):
            for _phase, over, do, option in ti.static(self.phases):
                if ti.static(over == POINTS):
                    for p in range(self.particles.active[None]):
                        do(p, 0, self.at(done + number, steps, dt, g0, g1, v0, v1, filling_drag), option, True)
                else:
                    for k in range(self.grid.nodes):
                        j = k // self.grid.columns
                        i = k - j * self.grid.columns
                        do(i, j, self.at(done + number, steps, dt, g0, g1, v0, v1, filling_drag), option, True)
            if ti.static(self.grid.follows in ("top", "surface")):
                for t in range(1):
                    self.grid.follow(t, self.at(done + number, steps, dt, g0, g1, v0, v1, filling_drag))

    @ti.kernel
    def _steps_alone(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real,
    ):  # fmt: skip
        ti.loop_config(serialize=True)
        for number in range(done, done + count):
            step = self.at(number, steps, dt, g0, g1, v0, v1, filling_drag)
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
                step = self.at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
                for phase, over, do, option in ti.static(self.phases):
                    if ti.static(phase > 0):
                        self.barrier.wait(passed, number * self.waits + phase - 1)
                    if ti.static(over == POINTS):
                        for p in range(first, last):
                            do(p, t, step, option, False)
                    else:
                        for j in range(low, high):
                            for i in range(self.grid.columns):
                                do(i, j, step, option, False)
                self.grid.follow(t, step)
