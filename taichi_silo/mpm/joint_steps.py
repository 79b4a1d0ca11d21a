"""Steps of one solver or of several by the same launches: each task runs over the points or nodes of all.

A graphics card wants a hundred thousand points; a silo of a study has some thousand. Several that take the same tasks
fill it together: a launch does what one of each would do. Each has its own values (sand, walls, speed, step, gravity)
and its own formulas, compiled beside those of the others; a thread does one point or node of one of them.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.executors import COLLECT, NODES, POINTS, ROWS, step_at
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real

if TYPE_CHECKING:
    from taichi_silo.mpm.tasks import Tasks

BURST = 4  # steps in a launch of one solver: the host's part of it is shared, but each step is compiled anew
LARGEST_BLOCK, LEAST_BLOCK = 256, 64  # threads; at 256 the registers of the law leave room for a second block
ENOUGH_BLOCKS = 128  # as many as a large card has processors: blocks are halved until there are so many
DONE, STEPS = 0, 1  # columns of the plan


class Request(NamedTuple):
    """Steps `done` to `done + asked` of a schedule of `steps` (see `Solver.advance`)."""

    done: int
    asked: int
    steps: int
    dt: float
    g0: float
    g1: float
    v0: float
    v1: float
    drag: float
    filling_drag: float

    def after(self, count: int) -> "Request":
        """What is left of it after so many steps."""
        return self._replace(done=self.done + count, asked=self.asked - count)


COLUMNS = len(Request._fields) - 1  # of the plan: all but how many are asked for


def block_of(threads: int) -> int:
    """How many threads stand in a block."""
    block = LARGEST_BLOCK
    while block > LEAST_BLOCK and threads < ENOUGH_BLOCKS * block:
        block //= 2
    return block


@ti.data_oriented
class JointSteps:
    """The launches of solvers that take the same tasks (`Tasks.tasks`, over the same things in the same order)."""

    def __init__(self, members: tuple["Tasks", ...]):
        self.members, self.burst = members, 1 if len(members) > 1 or runtime.lacks_functions() else BURST
        self.kinds = tuple(task.over for task in members[0].tasks)
        most = [self._most(n) for n in range(len(self.kinds))]
        self.blocks = tuple(block_of(len(members) * one) for one in most)
        # places of each member in a loop over all; whole blocks, so that a block is of one member
        self.places = tuple(-(-one // block) * block for one, block in zip(most, self.blocks, strict=True))
        self.loops = tuple(len(members) * one for one in self.places)
        self.plan = ti.field(real, shape=(len(members), COLUMNS))

    def _most(self, n: int) -> int:
        """The most that a member has of what task n runs over."""
        kind = self.kinds[n]
        if kind in (POINTS, COLLECT):
            return max(one.particles.count for one in self.members)
        if kind == NODES:
            return max(one.grid.nodes for one in self.members)
        return max(one.rows(one.tasks[n]) for one in self.members) if kind == ROWS else 1

    def run(self, requests: Mapping["Tasks", Request], count: int) -> None:
        """Do the first `count` steps of each request; members that ask for nothing stand still."""
        plan = np.zeros((len(self.members), COLUMNS))
        for m, one in enumerate(self.members):
            if one in requests:
                done, _, *rest = requests[one]
                plan[m] = done, *rest
        put(self.plan, plan)
        done = 0
        while done < count:
            together = self.burst if count - done >= self.burst else 1
            self._steps(done, together)
            done += together

    @ti.func
    def step_of(self, m, number):
        """The step of member m."""
        dt, g0, g1, v0, v1 = self.plan[m, 2], self.plan[m, 3], self.plan[m, 4], self.plan[m, 5], self.plan[m, 6]
        return step_at(number, self.plan[m, STEPS], dt, g0, g1, v0, v1, self.plan[m, 7], self.plan[m, 8])

    @ti.kernel
    def _steps(self, done: ti.i32, count: ti.template()):
        for later in ti.static(range(count)):
            for n, kind in ti.static(enumerate(self.kinds)):
                ti.loop_config(block_dim=self.blocks[n])
                for q in range(self.loops[n]):
                    for m, one in ti.static(enumerate(self.members)):
                        if q // self.places[n] == m and self.plan[m, STEPS] > 0.0:
                            number, place = ti.cast(self.plan[m, DONE], ti.i32) + done + later, q % self.places[n]
                            step = self.step_of(m, number)
                            if ti.static(kind in (POINTS, COLLECT)):
                                one.on_point(one.tasks[n], place, number, step)
                            elif ti.static(kind == NODES):
                                one.on_node(one.tasks[n], place, number, step)
                            elif ti.static(kind == ROWS):
                                one.on_row(one.tasks[n], place, number, step)
                            elif place == 0:
                                one.on_grid(one.tasks[n], place, number, step)
