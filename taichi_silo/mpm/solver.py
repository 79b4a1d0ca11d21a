"""The explicit step, in the order of the paper's section 3."""

import math
from collections.abc import Iterable, Sequence
from types import SimpleNamespace
from typing import Any

from taichi_silo.mpm import runtime
from taichi_silo.mpm.contracts import Filter, Law, Shape, Transfer, Wall
from taichi_silo.mpm.executors import NODES, POINTS, ROWS, SCATTER, Executor, Phase, Threads
from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.filters import Unfiltered
from taichi_silo.mpm.g2p import affine_of, at_point, before, deform, gradient_of, move, respond
from taichi_silo.mpm.geometry import Surroundings
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.grid_update import integrate_eights, integrate_node, second_velocity_of_node
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import Local, NonLocal
from taichi_silo.mpm.p2g import scatter, second_scatter
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.readings import Readings, Record, TaskReadings
from taichi_silo.mpm.simd import selftest
from taichi_silo.mpm.simd.executor import Simd, hindrance
from taichi_silo.mpm.simd.store import HALVES
from taichi_silo.mpm.tasks import Tasks
from taichi_silo.mpm.tensors import norm
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls.friction import AtOnce, Delayed
from taichi_silo.mpm.walls.outlets import OPENED
from taichi_silo.mpm.walls.surfaces import NoSurfaces, Surface, Surfaces

SOLID = 0.6  # share of grains in the sand of what inclined walls take for a full cell
STRESS_UPDATES = ("last", "first", "modified")


@ti.data_oriented
class Solver:
    """Explicit material point method.

    Parameters
    ----------
    particles, grid : the state.
    shape : of `taichi_silo.mpm.shapes`.
    law : of `taichi_silo.mpm.laws`.
    walls : tuple of walls of `taichi_silo.mpm.walls`, applied in this order.
    control : noise control.
    down : unit vector along which gravity acts.
    averaging : `Local()`, or a `NonLocal` of the same particles.
    surroundings : geometry and ambient pressure.
    transfer : of `taichi_silo.mpm.velocity_transfer`.
    stress_update : "last", from the velocities that the nodes have after the step (Bardenhagen 2002); "first", from
        those before it; "modified", last, from velocities that the points have given to the nodes once more (Sulsky
        et al. 1995).
    filtering : a class of `taichi_silo.mpm.filters`, or None.
    surfaces : walls of `taichi_silo.mpm.walls.surfaces` that do not follow the grid.
    friction_delay_s : time in which friction at walls follows the normal force [s] (see `walls.friction`); 0: at once;
        None: that in which a wave crosses the points' lesser extent three times. For bodies that rebound, 0.
    shared : whether a phase is one parallel task; None: on a GPU.
    simd : whether eight points go at once; None: wherever that is possible and can be trusted on this machine.

    Attributes
    ----------
    executor : what runs the phases (see `executors`).
    impulses : of walls and noise control since they were last read.
    simd_refused : why the vector unit is not used although it could be; else empty.

    Raises
    ------
    ValueError
        if the stress update is unknown or does not go with the transfer, if `simd` is asked for and not possible, or
        if the grid has not one copy of its sums for each thread.

    """

    MIRRORED = False  # whether the grid ends with an axis of symmetry

    def __init__(
        self, particles: Particles, grid: Grid, shape: Shape, law: Law, walls: Iterable[Wall] = (),
        control: NoiseControl | None = None, down: Sequence[float] = (0.0, -1.0), averaging: NonLocal | None = None,
        surroundings: Surroundings | None = None, shared: bool | None = None, transfer: Transfer | None = None,
        stress_update: str = "last", filtering: Filter | None = None, simd: bool | None = None,
        surfaces: Sequence[Surface] = (), friction_delay_s: float | None = None,
    ):  # fmt: skip
        self.particles, self.grid, self.shape, self.law = particles, grid, shape, law
        self.walls, self.control = tuple(walls), control or NoiseControl()
        self.surroundings = surroundings or Surroundings()
        # what a kernel asks for only where it is ACTIVE
        self.averaging: Any = averaging or Local()
        self.filter: Any = filtering(particles, grid, law, self.MIRRORED) if filtering else Unfiltered()
        self.surfaces: Any = NoSurfaces()
        self.transfer = transfer or Flip()
        self.second_walls = () if self.transfer.SECOND_TRANSFER else self.walls
        self.down = float(down[0]), float(down[1])
        self.stress_update = stress_update
        self.stable_fraction = shape.stable_fraction
        if surfaces:
            self.surfaces = Surfaces(
                surfaces, grid, SOLID * law.grain_density, len(self.walls), self.surroundings.geometry.depth
            )
        rubs = any(getattr(wall.contact, "coefficient", 0.0) > 0.0 for wall in (*self.walls, *surfaces))
        self.friction: Any = AtOnce()
        if rubs and friction_delay_s != 0.0:
            stations = self.surfaces.count if surfaces else 0
            self.friction = Delayed(particles, grid, len(self.walls), stations, friction_delay_s)
        on_tasks = not runtime.is_cpu() if shared is None else shared
        readings = TaskReadings if on_tasks else Readings
        self.readings = readings(self.walls, len(surfaces), particles, grid, law)
        self.impulses, self.sums = self.readings.impulses, self.readings.sums
        self.simd_refused = ""
        self.executor = self._executor(on_tasks, simd)

    def _executor(self, on_tasks: bool, simd: bool | None) -> Executor:
        """What runs the phases, as the arguments ask, or the fastest that can be trusted."""
        obstacle = "its phases are parallel tasks" if on_tasks else hindrance(self)
        if simd and obstacle:
            raise ValueError(f"the step cannot run on lanes because {obstacle}")
        if simd is None and not obstacle:
            self.simd_refused = selftest.failure()
            simd = not self.simd_refused
        self.averaging.hold(HALVES if simd else 1 if on_tasks else runtime.threads())
        if not simd:
            self.grid.hold()
        phases = tuple(self.phases())
        if simd:
            return Simd(phases, self)
        store = Fields(self.particles, self.grid, self.shape, on_tasks)
        return Tasks(phases, store, self) if on_tasks else Threads(phases, store)

    @property
    def threads(self) -> int:
        """Number of CPU threads that share a step; 1 on a GPU."""
        return self.executor.threads

    # --- the step -------------------------------------------------------------------------------------------------

    def phases(self) -> list[Phase]:
        """The phases of a step in their order; the only place where it is written."""
        if self.stress_update not in STRESS_UPDATES:
            known = ", ".join(STRESS_UPDATES)
            raise ValueError(f"stress update is {self.stress_update!r}; it must be one of {known}")
        if self.transfer.SECOND_TRANSFER and self.stress_update != "last":
            given = f"stress update is {self.stress_update!r}"
            raise ValueError(f"{given}; with the transfer {self.transfer} it must be 'last'")
        if self.stress_update != "last" or self.transfer.SECOND_TRANSFER:
            self.grid.hold_second()
        velocity, second = self.grid.velocity, self.grid.second_velocity
        press = [Phase(ROWS, self._press)] if self.surfaces.ACTIVE else []
        after = [*self.averaging.phases(), Phase(POINTS, self._respond)] if self.averaging.ACTIVE else []
        after += self.filter.phases() if self.filter.ACTIVE else []
        if self.stress_update == "first":
            return [
                Phase(SCATTER, self._scatter, "motion"),
                Phase(NODES, self._second_velocity, "keeps sums"),
                Phase(POINTS, self._stress, second),
                *after,
                Phase(SCATTER, self._scatter, "force"),
                Phase(NODES, self._integrate, "last"),
                *press,
                Phase(POINTS, self._move, second),
            ]
        if self.stress_update == "modified" or self.transfer.SECOND_TRANSFER:
            return [
                Phase(SCATTER, self._scatter, "all"),
                Phase(NODES, self._integrate, "keeps mass"),
                *press,
                Phase(SCATTER, self._second_scatter),
                Phase(NODES, self._second_velocity, "last"),
                Phase(POINTS, self._gather, velocity if self.transfer.SECOND_TRANSFER else second),
                *after,
            ]
        return [
            Phase(SCATTER, self._scatter, "all"),
            Phase(NODES, self._integrate, "last", eights=self._integrate_eights),
            *press,
            Phase(POINTS, self._gather, velocity),
            *after,
        ]

    def advance(
        self, steps: int, dt: float, gravity: Sequence[float] = (0.0, 0.0),
        plate_velocity: Sequence[float] = (0.0, 0.0), stage: str = "flow",
    ) -> None:  # fmt: skip
        """Do `steps` steps of `dt` seconds.

        `gravity` [m/s2] and `plate_velocity` [m/s] are pairs, at the beginning and the end, and vary linearly between;
        `stage` is that of the noise control (`NoiseControl.rates`).
        """
        schedule = (*map(float, gravity), *map(float, plate_velocity), *self.control.rates(stage))
        self.executor.lend()  # somebody may have changed the fields
        if steps == 0:  # compiles
            self.executor.run(0, 0, 0, dt, *schedule)
            self.executor.hand_back()
            return
        if self.friction.ACTIVE:
            found = self.point_sums()
            self.friction.know_waves(self.grid.cell_size / found.transit - found.speed)
        filters = self.filter.BETWEEN_LAUNCHES and (stage == "flow" or not self.filter.waits)
        looks = self.averaging.ACTIVE or filters
        if filters:
            self.filter.begin()
        done = 0
        try:
            while done < steps:
                chunk = steps - done
                fastest = self._fastest((steps - done) * dt, gravity, plate_velocity) if looks else 0.0
                if self.averaging.ACTIVE:
                    self.executor.hand_back()
                    self.averaging.refresh()
                    chunk = min(chunk, self.averaging.steps_within(fastest, dt))
                if filters:
                    chunk = min(chunk, self.filter.steps_within(fastest, dt))
                self.executor.run(done, chunk, steps, dt, *schedule)
                if filters:
                    self.filter.passed(chunk, fastest, dt)
                done += chunk
        finally:
            self.executor.hand_back()

    def _fastest(self, duration_s: float, gravity: Sequence[float], plate_velocity: Sequence[float]) -> float:
        """How fast a point may become in a time, relative to the grid [m/s]: carried by a plate, or in free fall."""
        speed = self.executor.speed()
        if speed is None:
            speed = self.sums.speed()
        if min(plate_velocity) <= OPENED:
            return speed + max(map(abs, gravity)) * duration_s
        return speed + max(map(abs, plate_velocity))

    def run_for(
        self, duration_s: float, gravity: float = 0.0, plate_velocity: float = 0.0, safety: float = 0.9
    ) -> float:  # fmt: skip
        """Advance by a time in equal steps, of at most `safety` times what is stable now; returns the step [s].

        `gravity` [m/s2] acts along `down`, `plate_velocity` [m/s] moves the walls that have a `motion`.
        """
        steps = max(1, math.ceil(duration_s / (safety * self.point_sums().stable_step)))
        self.advance(steps, duration_s / steps, (gravity, gravity), (plate_velocity, plate_velocity))
        return duration_s / steps

    def point_sums(self) -> SimpleNamespace:
        """What `PointSums` finds, and `stable_step`: the shape's stable fraction of the least h / (c + |v|) [s].

        Raises
        ------
        RunFailed
            if a thread waited in vain for the others.

        """
        self.executor.check()
        self.executor.lend()
        return self._with_stable_step(self.sums.read())

    def record(self) -> Record:
        """What `impulses.read_and_reset` and `point_sums` give, read at once; of the points as `advance` left them."""
        self.executor.check()
        reaction, control, found = self.readings.record()
        return reaction, control, self._with_stable_step(found)

    def _with_stable_step(self, found: SimpleNamespace) -> SimpleNamespace:
        found.stable_step = found.transit * self.stable_fraction
        return found

    # --- its phases: `store` is where the executor keeps points and nodes (see `field_store`) ------------------------

    @ti.func
    def _scatter(self, store: ti.template(), p, t, step, what: ti.template()):
        """Particles to grid: mass and momentum ("motion"), internal force ("force"), or "all"."""
        scatter(store, self.transfer, self.surroundings, p, t, what != "force", what != "motion")

    @ti.func
    def _integrate(self, store: ti.template(), i, j, step, what: ti.template()):
        """Equation of motion of a node, noise control, walls."""
        integrate_node(
            store, self.grid, self.walls, self.surfaces, self.friction, self.control, self.impulses,
            self.down, i, j, step, what == "last",
        )  # fmt: skip

    @ti.func
    def _integrate_eights(self, store: ti.template(), first, count, j, step):
        """The same of nodes that no wall holds, eight at once."""
        integrate_eights(store, self.grid, self.control, self.impulses, self.down, first, count, j, step)

    @ti.func
    def _press(self, store: ti.template(), j, step, option: ti.template()):
        """New tractions of the surfaces' stations in row j."""
        self.surfaces.press_row(self.friction, j, step.dt)

    @ti.func
    def _second_scatter(self, store: ti.template(), p, t, step, option: ti.template()):
        """To the nodes once more: the point's new velocity, or (XPIC) the old one as the grid saw it."""
        v = at_point(self.particles, self.grid, self.shape, self.grid.velocity, p, t)
        dv = at_point(self.particles, self.grid, self.shape, self.grid.change, p, t)
        given = v - dv
        if ti.static(not self.transfer.SECOND_TRANSFER):
            given = self.transfer.carried(self.particles.velocity[p], v, dv, v, step.dt)
        second_scatter(store, p, t, given)

    @ti.func
    def _second_velocity(self, store: ti.template(), i, j, step, what: ti.template()):
        """Velocity of a node from its sums alone; what strains the sand also obeys the walls."""
        second_velocity_of_node(self.grid, self.second_walls, i, j, step, what == "last")

    @ti.func
    def _gather(self, store: ti.template(), p, t, step, field: ti.template()):
        """Grid to particles: motion, and stress from the gradient of a nodal velocity."""
        self._update_point(store, p, t, step, field, True, True)

    @ti.func
    def _stress(self, store: ti.template(), p, t, step, field: ti.template()):
        """Grid to particles: stress only."""
        self._update_point(store, p, t, step, field, False, True)

    @ti.func
    def _move(self, store: ti.template(), p, t, step, field: ti.template()):
        """Grid to particles: motion only."""
        self._update_point(store, p, t, step, field, True, False)

    @ti.func
    def _respond(self, store: ti.template(), p, t, step, option: ti.template()):
        """Stress of point p under its kept strain rate and the non-local norm of it."""
        known = before(store, self.law, p)
        d0, d1, d2, d3, spin, length = self.averaging.kept(store, p)
        d_bar = self.averaging.mean(store, p)
        respond(known, store, self.law, p, (d0, d1, d2, d3), spin, length, d_bar, step.dt)

    # --- a point --------------------------------------------------------------------------------------------------

    @ti.func
    def _update_point(
        self, store: ti.template(), p, t, step, field: ti.template(), motion: ti.template(), stress: ti.template()
    ):  # fmt: skip
        """Motion, and stress, of point p from what it gathers, its strain rate from a nodal velocity `field`."""
        if ti.static(self.transfer.GRADIENT == "affine"):
            store.write("affine", p, affine_of(self.particles, self.grid, self.shape, p, t))
        known = before(store, self.law, p)
        gathered = store.gather(field, p, t)
        L = gradient_of(store, self.grid, self.surroundings.geometry, p, t, gathered)
        if ti.static(motion):
            second = self._second(p, t, gathered)
            move(store, self.grid, self.transfer, self.control, p, step, gathered, second)
            deform(store, self.grid, self.shape, self.transfer, p, t, L, step.dt)
        if ti.static(stress):
            D, spin = (L[0], L[3], L[4], 0.5 * (L[1] + L[2])), 0.5 * (L[1] - L[2])
            length = norm(D)
            if ti.static(self.averaging.ACTIVE):  # it waits for the neighbours' strain rates
                self.averaging.keep(store, p, t, D, spin, length)
            else:
                respond(known, store, self.law, p, D, spin, length, length, step.dt)

    @ti.func
    def _second(self, p, t, gathered):
        """Velocity (x, y) that a second transfer brought back; the grid's own without one."""
        if ti.static(self.transfer.SECOND_TRANSFER):
            back = at_point(self.particles, self.grid, self.shape, self.grid.second_velocity, p, t)
            return back[0], back[1]
        return gathered[0], gathered[1]
