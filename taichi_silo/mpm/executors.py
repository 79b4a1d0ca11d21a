"""Who runs the phases of a step: one launch for many steps on the threads of a processor, or one task a phase.

A step is a tuple of `Phase`s (`Solver.phases`), each a function that knows one point, node or row. An executor runs
them, step after step: `Threads` on the fields, each thread over its own points and rows; `Tasks` on the fields, one
parallel task a phase, with atomic sums, as on a GPU; `simd.executor.Simd` on eight points at once. All give the same
step. The functions get as first argument the store that the executor works on, with these members:

`read(name, p)`, `write(name, p, value)`
    a field of point p (see `Particles`): a value, or a tuple of its components.
`keep(field, p, value)`, `kept(field, p)`, `each(function, p)`
    the entry of point p in a scalar field by points, and the value of a function of the point's number.
`gather(field, p, t)`
    what `g2p.gather` finds for point p.
`read_sums(i, j, last)`, `write_velocity(k, x, y, old)`
    mass, momentum (2) and force (2) of node (i, j), which are emptied; velocity and change of node k.
`clear_axis(k, j)`, `fold(k, image, j)`, `unfold(k, image)`
    of a row j with an axis of symmetry: see `mirrored_solver`.

For the vector unit p is the number of a group of eight points, and a value eight numbers.
"""

from typing import NamedTuple

import taichi as ti

from taichi_silo.errors import RunFailed
from taichi_silo.mpm import g2p, runtime
from taichi_silo.mpm.contracts import Shape
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real

SCATTER, POINTS, NODES, ROWS = range(4)  # what a phase runs over; SCATTER: points that add to their nodes
BURST = 8  # steps in a launch of tasks: the host's part of a launch is shared
SPIN_LIMIT = 500_000_000  # turns of a waiting thread before it gives up (some seconds)
LOST = 32  # slot of `arrivals` that says that one did
MOST_ARRIVALS = 1_000_000_000  # counted before they start anew


class Phase(NamedTuple):
    """A part of a step.

    over : SCATTER or POINTS: run(store, p, t, step, option), t being the number of the thread; NODES: run(store, i, j,
        step, option); ROWS (of nodes): run(store, j, step, option).
    run : the function.
    option : a compile-time constant for it.
    waits : whether it needs what other threads did in the phase before.
    """

    over: int
    run: object
    option: object = None
    waits: bool = True


@ti.dataclass
class Step:
    """What varies from step to step."""

    dt: real  # [s]
    gravity: real  # [m/s2]
    plate_velocity: real  # of the moving plates [m/s]
    filling_drag: real  # [1/s]


@ti.func
def step_at(number, steps, dt, g0, g1, v0, v1, filling_drag):
    """Step `number` of so many, in which gravity goes linearly from g0 to g1, the plate velocity from v0 to v1."""
    part = (number + 0.5) / steps
    return Step(dt=dt, gravity=g0 + part * (g1 - g0), plate_velocity=v0 + part * (v1 - v0), filling_drag=filling_drag)


@ti.data_oriented
class Fields:
    """The store of an executor that works on the fields of particles and grid themselves."""

    def __init__(self, particles: Particles, grid: Grid, shape: Shape, atomic: bool):
        self.particles, self.grid, self.shape, self.atomic = particles, grid, shape, atomic
        self.read, self.write = particles.read, particles.write

    @ti.func
    def add(self, sums: ti.template(), k, value):
        """Add to entry k of a sum."""
        if ti.static(self.atomic):
            sums[k] += value
        else:
            sums[k] = sums[k] + value

    @ti.func
    def keep(self, field: ti.template(), p, value):
        """Set the entry of point p."""
        field[p] = value

    @ti.func
    def kept(self, field: ti.template(), p):
        """The entry of point p."""
        return field[p]

    @ti.func
    def each(self, function: ti.template(), p):
        """The function of p."""
        return function(p)

    @ti.func
    def gather(self, field: ti.template(), p, t):
        """What point p gathers."""
        return g2p.gather(self.particles, self.grid, self.shape, field, p, t)

    @ti.func
    def points_of(self, t, threads: ti.template()):
        """First of the points of thread t, and of those of the next."""
        count = self.particles.active[None]
        return t * count // threads, (t + 1) * count // threads

    @ti.func
    def scatter(self, run: ti.template(), t, threads: ti.template(), step, option: ti.template()):
        """The phase that adds to the nodes, for the points of thread t."""
        first, last = self.points_of(t, threads)
        for p in range(first, last):
            run(self, p, t, step, option)

    @ti.func
    def read_sums(self, i, j, last: ti.template()):
        """Mass, momentum and force of node (i, j) from all copies, which are emptied (the mass only if `last`)."""
        k = j * self.grid.columns + i
        m, momentum, force = self.grid.mass[k], self.grid.momentum[k], self.grid.force[k]
        for copy in ti.static(range(1, self.grid.copies)):
            other = copy * self.grid.nodes + k
            m, momentum = m + self.grid.mass[other], momentum + self.grid.momentum[other]
            force = force + self.grid.force[other]
        for copy in ti.static(range(self.grid.copies)):
            other = copy * self.grid.nodes + k
            if ti.static(last):
                self.grid.mass[other] = 0.0
            self.grid.momentum[other] = ti.Vector([0.0, 0.0])
            self.grid.force[other] = ti.Vector([0.0, 0.0])
        return m, momentum[0], momentum[1], force[0], force[1]

    @ti.func
    def write_velocity(self, k, x, y, old):
        """Velocity (x, y) of node k, and its change from an old one."""
        self.grid.velocity[k] = ti.Vector([x, y])
        self.grid.change[k] = ti.Vector([x - old[0], y - old[1]])

    @ti.func
    def clear_axis(self, k, j):
        """Nothing crosses the axis at node k: no momentum and no force along x."""
        for copy in ti.static(range(self.grid.copies)):
            self.grid.momentum[copy * self.grid.nodes + k][0] = 0.0
            self.grid.force[copy * self.grid.nodes + k][0] = 0.0

    @ti.func
    def fold(self, k, image, j):
        """Add the mirrored sums of node `image` to those of node k, and empty them."""
        mirror, nothing = ti.Vector([-1.0, 1.0]), ti.Vector([0.0, 0.0])
        for copy in ti.static(range(self.grid.copies)):
            here, there = copy * self.grid.nodes + k, copy * self.grid.nodes + image
            self.grid.mass[here] = self.grid.mass[here] + self.grid.mass[there]
            self.grid.momentum[here] = self.grid.momentum[here] + mirror * self.grid.momentum[there]
            self.grid.force[here] = self.grid.force[here] + mirror * self.grid.force[there]
            self.grid.mass[there], self.grid.momentum[there], self.grid.force[there] = 0.0, nothing, nothing

    @ti.func
    def unfold(self, k, image):
        """Mirror the velocities of node k to node `image`."""
        mirror = ti.Vector([-1.0, 1.0])
        for velocity in ti.static((self.grid.velocity, self.grid.change, self.grid.second_velocity)):
            velocity[image] = mirror * velocity[k]


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
            self.arrivals.fill(0)
            self.passed = 0
        before = self.passed
        self.passed += waits * self.threads
        return before

    def check(self) -> None:
        """Raise RunFailed if a thread waited in vain for the others."""
        if self.threads > 1 and self.arrivals[LOST]:
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

    def __init__(self, phases: tuple[Phase, ...], grid: Grid, threads: int):
        self.grid, self.threads, self.barrier = grid, threads, Barrier(threads)
        waits = [number > 0 and phase.waits for number, phase in enumerate(phases)]
        self.waits = sum(waits)  # in a step
        self.phases = tuple((sum(waits[:n]), waits[n], *phase[:3]) for n, phase in enumerate(phases))

    @ti.func
    def steps(self, store: ti.template(), t, done, count, steps, dt, g0, g1, v0, v1, filling_drag, passed):
        """Steps `done` to `done + count` of so many on thread t."""
        first, last = store.points_of(t, self.threads)
        low, high = t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads
        for number in range(count):
            step = step_at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
            for before, waits, over, run, option in ti.static(self.phases):
                if ti.static(waits):
                    self.barrier.wait(passed, number * self.waits + before)
                if ti.static(over == SCATTER):
                    store.scatter(run, t, self.threads, step, option)
                elif ti.static(over == POINTS):
                    for p in range(first, last):
                        run(store, p, t, step, option)
                elif ti.static(over == NODES):
                    for j in range(low, high):
                        for i in range(self.grid.columns):
                            run(store, i, j, step, option)
                else:
                    for j in range(low, high):
                        run(store, j, step, option)
            self.grid.follow(t, step)


@ti.data_oriented
class Threads:
    """Plain loops on the threads of a processor, each with its own points, rows and copy of the sums."""

    def __init__(self, phases: tuple[Phase, ...], particles: Particles, grid: Grid, shape: Shape):
        threads = runtime.threads()
        if grid.copies != threads:
            raise ValueError(f"grid has {grid.copies} copies of its sums; {threads} threads need as many")
        self.threads = threads
        self.loop, self.store = PhaseLoop(phases, grid, threads), Fields(particles, grid, shape, atomic=False)

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Do steps `done` to `done + count` of a schedule of `steps` (see `Solver.advance`)."""
        self._steps(done, count, steps, dt, *schedule, self.loop.barrier.reserve(count * self.loop.waits))

    def check(self) -> None:
        """Raise RunFailed if the threads lost each other."""
        self.loop.barrier.check()

    def state(self) -> dict | None:
        """What the executor keeps between launches beside the fields, for a checkpoint: nothing."""

    def restore(self, state: dict | None) -> None:
        """Go on from fields that were loaded."""

    @ti.kernel
    def _steps(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real, passed: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for t in range(self.loop.threads):
            self.loop.steps(self.store, t, done, count, steps, dt, g0, g1, v0, v1, filling_drag, passed)


@ti.data_oriented
class Tasks:
    """One parallel task a phase, with atomic sums, as on a GPU; some steps a launch."""

    threads = 1

    def __init__(self, phases: tuple[Phase, ...], particles: Particles, grid: Grid, shape: Shape):
        self.phases, self.grid, self.particles = tuple(phase[:3] for phase in phases), grid, particles
        self.store = Fields(particles, grid, shape, atomic=True)

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Do steps `done` to `done + count` of a schedule of `steps` (see `Solver.advance`)."""
        number = done
        while number < done + count:
            together = BURST if done + count - number >= BURST else 1
            self._steps(number, together, steps, dt, *schedule)
            number += together

    def check(self) -> None:
        """Tasks do not wait for each other."""

    def state(self) -> dict | None:
        """What the executor keeps between launches beside the fields, for a checkpoint: nothing."""

    def restore(self, state: dict | None) -> None:
        """Go on from fields that were loaded."""

    @ti.kernel
    def _steps(
        self, done: ti.i32, count: ti.template(), steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real,
    ):  # fmt: skip
        for number in ti.static(range(count)):
            for over, run, option in ti.static(self.phases):
                if ti.static(over in (SCATTER, POINTS)):
                    for p in range(self.particles.active[None]):
                        step = step_at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
                        run(self.store, p, 0, step, option)
                elif ti.static(over == NODES):
                    for k in range(self.grid.nodes):
                        step = step_at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
                        run(self.store, k % self.grid.columns, k // self.grid.columns, step, option)
                else:
                    for j in range(self.grid.rows):
                        run(self.store, j, step_at(done + number, steps, dt, g0, g1, v0, v1, filling_drag), option)
            if ti.static(self.grid.follows in ("top", "surface")):
                for t in range(1):
                    self.grid.follow(t, step_at(done + number, steps, dt, g0, g1, v0, v1, filling_drag))
