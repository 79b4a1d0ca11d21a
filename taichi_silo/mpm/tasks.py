"""Steps as parallel tasks, one thread of a GPU for each point or node; the launches of a GPU."""

from typing import Any, NamedTuple

from taichi_silo.mpm import runtime
from taichi_silo.mpm.cell_lists import CellLists
from taichi_silo.mpm.executors import COLLECT, NODES, POINTS, ROWS, SCATTER, Executor, Phase, step_at
from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.one_node import take
from taichi_silo.mpm.runtime import real

BURST = 4  # steps in a launch: the host's part of it is shared, but each step is compiled anew
LARGEST_BLOCK, LEAST_BLOCK = 256, 64  # threads; at 256 the registers of the law leave room for a second block
ENOUGH_BLOCKS = 128  # as many as a large card has processors: blocks are halved until there are so many


class Task(NamedTuple):
    """What is done in one parallel loop.

    over : POINTS or COLLECT, NODES, ROWS; None: the grid's own step.
    take : a phase over points whose gifts each node takes before it runs, and whether it is the first of the step.
    run, option, rows : of the phase; None: nothing more.
    enter : whether points then enter the lists of the next step.
    """

    over: int | None
    take: tuple[Any, Any, bool] | None = None
    run: Any = None
    option: Any = None
    rows: int = 0
    enter: bool = False

    @property
    def takes(self) -> bool:
        """Whether nodes take something."""
        return self.take is not None

    @property
    def runs(self) -> bool:
        """Whether a phase runs."""
        return self.run is not None


def tasks_of(phases: tuple[Phase, ...], stretches: bool) -> tuple[Task, ...]:
    """The phases of a step as tasks; nodes move in the task in which they take what points give.

    Points enter the lists of the next step in their last phase, or on a grid that `stretches` after it has done so.
    """
    tasks: list[Task] = []
    for phase in phases:
        over, run, option = phase[:3]
        if over == SCATTER:
            tasks.append(Task(NODES, (run, option, not tasks)))
        elif over == NODES and tasks and tasks[-1].over == NODES and not tasks[-1].runs:
            tasks[-1] = tasks[-1]._replace(run=run, option=option)
        else:
            tasks.append(Task(over, run=run, option=option, rows=phase.rows))
    if stretches:
        return (*tasks, Task(None), Task(POINTS, enter=True))
    last = max(number for number, task in enumerate(tasks) if task.over == POINTS)
    tasks[last] = tasks[last]._replace(enter=True)
    return tuple(tasks)


def block_of(threads: int) -> int:
    """How many threads stand in a block."""
    block = LARGEST_BLOCK
    while block > LEAST_BLOCK and threads < ENOUGH_BLOCKS * block:
        block //= 2
    return block


@ti.data_oriented
class Tasks(Executor):
    """One parallel task a phase, or for two: no sum waits for another, and their order is always the same.

    (Filters that COLLECT add in any order.)
    """

    def __init__(self, phases: tuple[Phase, ...], store: Fields):
        self.store, self.particles, self.grid = store, store.particles, store.grid
        self.lists = CellLists(self.particles, self.grid, store.shape)
        self.tasks = tasks_of(phases, self.grid.follows in ("top", "surface"))
        self.by_points, self.by_nodes = block_of(self.particles.count), block_of(self.grid.nodes)

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Launches of some steps, then of one; on Vulkan of one, where compiling takes longest."""
        burst, number = 1 if runtime.lacks_functions() else BURST, done
        self.lists.fill(done % 2)
        while number < done + count:
            together = burst if done + count - number >= burst else 1
            self._steps(number, together, steps, dt, *schedule)
            number += together

    @ti.kernel
    def _steps(
        self, done: ti.i32, count: ti.template(), steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        drag: real, filling_drag: real,
    ):  # fmt: skip
        for number in ti.static(range(count)):
            for task in ti.static(self.tasks):
                if ti.static(task.over in (POINTS, COLLECT)):
                    ti.loop_config(block_dim=self.by_points)
                    for p in range(self.particles.places()):
                        if self.particles.is_there(p):
                            step = step_at(done + number, steps, dt, g0, g1, v0, v1, drag, filling_drag)
                            if ti.static(task.runs):
                                task.run(self.store, p, 0, step, task.option)
                            if ti.static(task.enter):
                                self.lists.enter(p, (done + number + 1) % 2)
                elif ti.static(task.over == NODES):
                    ti.loop_config(block_dim=self.by_nodes)
                    for k in range(self.grid.nodes):
                        step = step_at(done + number, steps, dt, g0, g1, v0, v1, drag, filling_drag)
                        if ti.static(task.takes):
                            self._take(k, (done + number) % 2, step, task)
                        if ti.static(task.runs):
                            task.run(self.store, k % self.grid.columns, k // self.grid.columns, step, task.option)
                elif ti.static(task.over == ROWS):
                    for j in range(task.rows or self.grid.rows):
                        step = step_at(done + number, steps, dt, g0, g1, v0, v1, drag, filling_drag)
                        task.run(self.store, j, step, task.option)
                else:
                    for t in range(1):
                        self.grid.follow(t, step_at(done + number, steps, dt, g0, g1, v0, v1, drag, filling_drag))

    @ti.func
    def _take(self, k, turn, step, task: ti.template()):
        """What node k takes of its points; the first to take empty the lists of the next step."""
        run, option, first = ti.static(task.take)
        if ti.static(first):
            self.lists.empty(k, 1 - turn)
        take(self.store, self.lists, k, turn, run, step, option)
