"""Steps as parallel tasks, one thread of a GPU for each point or node."""

from typing import Any, NamedTuple

from taichi_silo.mpm import one_taichi
from taichi_silo.mpm.cell_lists import CellLists
from taichi_silo.mpm.executors import NODES, POINTS, SCATTER, Executor, Phase
from taichi_silo.mpm.field_memory import trees
from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.joint_steps import JointSteps, Request
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.one_node import take


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


@ti.data_oriented
class Tasks(Executor):
    """One parallel task a phase, or for two: no sum waits for another, and their order is always the same.

    (Filters that COLLECT add in any order.) `joint_steps` has the loops; a `crew` shares them among several solvers.
    """

    def __init__(self, phases: tuple[Phase, ...], store: Fields, solver: Any):
        self.store, self.particles, self.grid = store, store.particles, store.grid
        self.lists = CellLists(self.particles, self.grid, store.shape)
        self.tasks = tasks_of(phases, self.grid.follows in ("top", "surface"))
        self.trees = trees(store, self.lists, solver)
        self.alone: JointSteps | None = None

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Do them with those of the crew, if this thread is of one."""
        if count == 0:
            return
        self.lists.fill(done % 2)
        request = Request(done, count, steps, dt, *schedule)
        if crew := one_taichi.crew():
            crew.run(self, request)
        else:
            self.alone = self.alone or JointSteps((self,))
            self.alone.run({self: request}, count)

    @ti.func
    def on_point(self, task: ti.template(), p, number, step):
        """A task over points, for place p, in step `number`."""
        if p < self.particles.active[None]:
            if ti.static(task.runs):
                task.run(self.store, p, 0, step, task.option)
            if ti.static(task.enter):
                self.lists.enter(p, (number + 1) % 2)

    @ti.func
    def on_node(self, task: ti.template(), k, number, step):
        """A task over nodes, for node k."""
        if k < self.grid.nodes:
            if ti.static(task.takes):
                self._take(k, number % 2, step, task)
            if ti.static(task.runs):
                task.run(self.store, k % self.grid.columns, k // self.grid.columns, step, task.option)

    @ti.func
    def on_row(self, task: ti.template(), j, number, step):
        """A task over rows of nodes, for row j."""
        if j < self.rows(task):
            task.run(self.store, j, step, task.option)

    @ti.func
    def on_grid(self, task: ti.template(), j, number, step):
        """The grid's own step."""
        self.grid.follow(0, step)

    def rows(self, task: Task) -> int:
        """Over which a task runs."""
        return task.rows or self.grid.rows

    @ti.func
    def _take(self, k, turn, step, task: ti.template()):
        """What node k takes of its points; the first to take empty the lists of the next step."""
        run, option, first = ti.static(task.take)
        if ti.static(first):
            self.lists.empty(k, 1 - turn)
        take(self.store, self.lists, k, turn, run, step, option)
