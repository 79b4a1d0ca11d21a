"""From a scene to its history: fill the silo, let it settle, let it flow."""

import math
import time

import numpy as np

from taichi_silo.mpm.geometry import Surroundings
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.mirrored_solver import MirroredSolver
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import NonLocal
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import threads
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.solver import Solver
from taichi_silo.scene import known_limits
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation import filling, outflow
from taichi_silo.simulation.alarm import Alarm, Alarms
from taichi_silo.simulation.discharge import Ledger
from taichi_silo.simulation.discretise import (
    BOTTOM,
    LEFT,
    RIGHT,
    Section,
    grid_of,
    load,
    state_of_fill,
    surfaces_of,
    walls_of,
)
from taichi_silo.simulation.natural_period import wave_speed_of
from taichi_silo.simulation.outflow import OPENED, RAMP_PERIODS
from taichi_silo.simulation.record import Record

BODIES = 3  # of a record's profile: where walls after left, right and bottom begin
STEP_SAFETY = 0.95  # of the stable step, which changes within an interval
EXIT = 0.5  # of a cell below the floor: sand that has passed touches no node that can move


def noise_control(scene: Scene, period_s: float) -> NoiseControl:
    """As the scene asks for, scaled to the period of its column."""
    if scene.method.noise_control == "none":
        return NoiseControl()
    return NoiseControl.for_column(period_s, scene.silo.height_m / scene.silo.width_m)


def flow_time(scene: Scene, period_s: float) -> float:
    """Duration of the flow, at most [s]."""
    flow = scene.flow
    if flow.outflow == "gravity":
        return flow.longest_s
    return flow.displacement_m / flow.speed_m_per_s + 0.5 * RAMP_PERIODS * period_s


class Simulation:
    """The silo of a scene, ready to be filled; Taichi has been started.

    Iterate over `run()`: it yields a `Record` after each interval. Observers look at the public attributes in between;
    there it can be left, and go on in another process (`state.py`).
    """

    def __init__(self, scene: Scene, control: NoiseControl | None = None, lanes: bool | None = None):
        self.scene = scene
        self.warnings = known_limits.of_method(scene)  # sentences on what is known, and what observers find
        self.alarms = Alarms()  # what has been found wrong
        # mass scaling: heavier grains under a smaller gravity have the same weight
        self.law = scene.law
        self.gravity = scene.method.gravity_m_per_s2 / scene.method.mass_scaling
        self.density = self.law.grain_density / (1.0 + scene.sand.void_ratio)  # inertial
        self.time, self.steps, self.stepping_seconds = 0.0, 0, 0.0
        self._begin()
        per_axis = math.isqrt(scene.grid.points_per_cell)
        self.spacing = scene.grid.cell_size_m / per_axis

        self.shape = SHAPES[scene.grid.shape](0.5 / per_axis)
        self.transfer = scene.method.transfer_of_points()

        self.wave_speed = wave_speed_of(scene)
        self.period = 4.0 * scene.silo.height_m / self.wave_speed
        self.rows_per_period = scene.output.records_per_period
        self.control = noise_control(scene, self.period) if control is None else control

        self.section = Section.of(scene)
        self.half, self.whole, self.width = self.section.half, self.section.whole, self.section.width
        self.columns = self.section.columns

        self.grid = grid_of(scene, self.section, threads())
        self.fill_state = state_of_fill(scene, self.section, self.law, self.density)
        count = len(self.fill_state["mass"])
        self.particles = Particles(count, Particles.extras(self.law, self.shape, self.transfer))
        load(self.particles, self.fill_state)
        self.identity = np.arange(count)  # of the points, in the order of the fill
        self.mass = self.whole * float(self.fill_state["mass"].sum())  # of the full silo [kg/m]
        self._held = -1, 0.0  # loads of the particles, and the mass they then had
        kernel, self.about_averaging = scene.averaging.kernel(scene.sand, self.spacing)
        self.averaging = NonLocal(kernel, self.particles, self.spacing) if kernel else None
        self.walls = walls_of(scene, self.section, self.grid)
        self.surfaces = surfaces_of(scene, self.section)
        self.lanes = lanes if scene.machine.lanes else False
        self.use(self.control)
        if why := self.solver.simd_refused:
            slower = "Steps take two to four times as long."
            self.warnings.append(f"The processor's vector unit is not used: {why}. {slower}")
        self.ledger = None if scene.silo.floor_is_outlet else Ledger(self.particles, -EXIT * scene.grid.cell_size_m)
        self.solver.advance(0, 1.0)  # compiles

    def _begin(self) -> None:
        """Nothing is filled in yet."""
        self.displacement, self.stage = 0.0, "filling"
        self.settled = False  # whether the wall force had come to rest before the flow
        self.finished = False  # whether the flow has come to its end
        self.filling = filling.Progress()
        self.flow_start, self.bottom_speed = None, 0.0  # [s], [m/s]
        self.left_at = self.time  # when sand last left, or could not yet [s]
        self.step = math.inf  # of the last interval [s]
        self.after, self.seen = None, None  # last survey, and of which points

    def refill(self) -> None:
        """Stand where the simulation stood before its first interval, with new sand and new books; clocks go on."""
        self._begin()
        load(self.particles, self.fill_state)
        self.identity = np.arange(self.particles.count)
        self.grid.forget_all()
        self.use(self.control)
        if self.ledger is not None:
            self.ledger = Ledger(self.particles, self.ledger.exit)

    def use(self, control: NoiseControl) -> None:
        """From now on step with a solver of this noise control."""
        self.solver = (MirroredSolver if self.half else Solver)(
            self.particles, self.grid, self.shape, self.law, self.walls, control, averaging=self.averaging,
            surroundings=Surroundings(self.section.geometry), surfaces=self.surfaces, simd=self.lanes,
            **self.scene.method.solver_options(),
        )  # fmt: skip

    # --- stages ---------------------------------------------------------------------------------------------------

    @property
    def interval(self) -> float:
        """Time between records [s]."""
        return self.period / self.rows_per_period

    @property
    def held_mass(self) -> float:
        """Of the sand that is in the silo now [kg/m]."""
        if self._held[0] != self.particles.revision:
            there = self.particles.mass.to_numpy()[: self.particles.active[None]]
            self._held = self.particles.revision, self.whole * float(there.sum())
        return self._held[1]

    @property
    def filling_time(self) -> float:
        """Duration of the filling, without the rest after it [s]."""
        return filling.duration(self.scene, self.period)

    @property
    def flow_time(self) -> float:
        """Duration of the flow, at most [s]."""
        return flow_time(self.scene, self.period)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the walls beside left, right and bottom, in the order of a record's profile."""
        return tuple(surface.name for surface in self.surfaces)

    def run(self):
        """Fill, settle and flow; yields a Record after each interval."""
        yield from self.fill()
        yield from self.flow()

    def fill(self):
        """Get the sand in, then rest until the wall force no longer changes."""
        if self.stage == "filling":
            yield from filling.fill(self)

    def flow(self):
        """Lower the bottom or the gate, or open the gate; yields a Record after each interval."""
        if self.stage == "filling":
            self.stage, self.flow_start, self.left_at = "flow", self.time, self.time
        if not self.finished:
            yield from outflow.flow(self)
            self.finished = True

    def advance(
        self, duration: float, gravity=None, plate_velocity=(0.0, 0.0), growth: float = 1.0, longer: float = math.inf
    ) -> Record:
        """Steps over an interval [s]; gravity and plate velocity, pairs, vary linearly from its start to its end.

        `growth` is a factor of the time step, for intervals in which the stress grows; `longer` how many times as long
        as in the last interval it may be at most.
        """
        scene, solver = self.scene, self.solver
        gravity = (self.gravity, self.gravity) if gravity is None else gravity
        before = self.after if self.seen == self.particles.revision else solver.point_sums()
        step = scene.method.time_step(before, STEP_SAFETY)
        if scene.method.time_step_s is None:
            step = min(growth * step, longer * self.step)
        steps = max(1, math.ceil(duration / step - 1e-9))
        dt = self.step = duration / steps
        held = self.held_mass
        drag = self.control.filling_drag if self.stage == "filling" else 0.0
        begun = time.perf_counter()
        solver.advance(steps, dt, gravity, plate_velocity, drag)
        reaction, control = solver.impulses.read_and_reset()  # waits for the device
        self.stepping_seconds += time.perf_counter() - begun
        after = self.after = solver.point_sums()
        self.seen = self.particles.revision
        if after.strays:
            self.alarms.take(self._astray(after.strays, dt), self)
        self.time += duration
        self.steps += steps
        gone = self._settle()
        if plate_velocity[0] > OPENED:
            self.displacement -= 0.5 * (plate_velocity[0] + plate_velocity[1]) * duration
        else:  # of a gate that would have let out as much
            self.displacement = gone / (self.density * scene.silo.outlet_share_m)
        gate_moves = OPENED < plate_velocity[1] < 0.0  # only then does it work on the sand
        stands = self._stands(reaction) / duration if gate_moves else 0.0
        reaction = self._joined(reaction) / duration
        forces = self.section.forces(reaction)
        force = forces.sum(axis=1)
        lift = self.whole * (after.height - before.height)
        work = self._work(held, lift, force[BOTTOM, 1] - stands, gravity, plate_velocity, duration)
        return Record(
            time_s=self.time,
            stage=self.stage,
            displacement_m=self.displacement,
            interval_s=duration,
            bottom_N_per_m=force[BOTTOM, 1],
            left_normal_N_per_m=force[LEFT, 0],
            left_shear_N_per_m=force[LEFT, 1],
            right_normal_N_per_m=-force[RIGHT, 0],
            right_shear_N_per_m=force[RIGHT, 1],
            weight_N_per_m=held * 0.5 * (gravity[0] + gravity[1]),
            momentum_rate_N_per_m=self.whole * (after.momentum - before.momentum) / duration,
            control_N_per_m=self.whole * control[:, 1].sum() / duration,
            kinetic_energy_J_per_m=self.whole * after.kinetic_energy,
            kinetic_gain_J_per_m=self.whole * (after.kinetic_energy - before.kinetic_energy),
            work_J_per_m=work,
            stored_J_per_m=self.whole * after.stored,
            time_step_s=dt,
            stable_step_s=after.stable_step,
            void_ratio_low=after.void_ratio_low,
            void_ratio_high=after.void_ratio_high,
            separated=self.points_per_computed * after.separated,
            strays=after.strays,
            speed_m_per_s=after.speed,
            profile=self.section.profile(reaction, forces),
            discharged_kg_per_m=gone,
            bodies_N_per_m=dict(zip(self.bodies, force[BODIES:].tolist(), strict=True)),
        )

    def _work(self, held: float, lift: float, push: float, gravity, plate_velocity, duration: float) -> float:
        """Of weight, and of the bottom or gate that moves, on the sand within an interval [J/m].

        `lift` is the change of mass times height in the grid, `push` the vertical force of what moves.
        """
        way = 0.5 * (plate_velocity[0] + plate_velocity[1]) * duration  # upwards
        if self.scene.silo.floor_is_outlet:
            lift += held * way
        if plate_velocity[0] <= OPENED:
            way = 0.0  # nothing presses on an open gate
        return push * way - 0.5 * (gravity[0] + gravity[1]) * lift

    def _stands(self, reaction: np.ndarray) -> float:
        """Vertical impulse of the floor beside a gate, which stands [N s/m]."""
        if self.scene.silo.floor_is_outlet:
            return 0.0
        floor = np.zeros_like(reaction)
        floor[BOTTOM] = reaction[BOTTOM]
        return float(self.section.forces(self._joined(floor))[BOTTOM, :, 1].sum())

    def _joined(self, reaction: np.ndarray) -> np.ndarray:
        """Impulses (left, right, bottom, bodies): those of a gate are the bottom's."""
        first = len(self.walls)
        return np.concatenate([reaction[:BOTTOM], reaction[BOTTOM:first].sum(axis=0)[None], reaction[first:]])

    def _settle(self) -> float:
        """Take out what has passed the exit; all that has left since the start [kg/m]."""
        if self.ledger is None:
            return 0.0
        kept = self.ledger.settle()
        if kept is not None:
            self.identity = self.identity[kept]
        return self.whole * self.ledger.mass

    # --- state ----------------------------------------------------------------------------------------------------

    @property
    def points_per_computed(self) -> int:
        """How many points of the whole silo one that is computed stands for."""
        return 2 if self.half or self.section.round else 1

    @property
    def origin_m(self) -> float:
        """Height of the grid's origin in the laboratory [m]."""
        return -self.displacement if self.scene.silo.floor_is_outlet else 0.0

    def points(self) -> dict[str, np.ndarray]:
        """All fields of the points of the whole silo as arrays.

        `position` is in the laboratory; `void_ratio`; `identity`, by which a point is found again in another state.
        Masses and volumes are per metre run, in a round silo of the point's own girth.
        """
        return self.section.points(self._computed(), self.scene.silo.width_m)

    def _computed(self) -> dict[str, np.ndarray]:
        arrays = self.particles.arrays()
        arrays["position"] = arrays["position"] + np.array([0.0, self.origin_m])
        arrays["void_ratio"] = arrays["volume"] * self.law.grain_density / arrays["mass"] - 1.0
        arrays["identity"] = self.identity
        return arrays

    def _astray(self, count: int, dt: float) -> Alarm:
        points = self._computed()
        within = self._within(points, self.width)
        first = int(np.argmin(within))
        place, point = points["position"][first], self.identity[first]
        lost = int((~np.isfinite(points["stress"]).all(axis=1) | ~np.isfinite(points["position"]).all(axis=1)).sum())
        if not np.isfinite(place).all():  # where it is cannot be said, but where it was filled in
            place = self.fill_state["position"][point]
        alarm = Alarm(
            "not finite" if lost else "outside the grid", True,
            f"{count} points left the silo or are not finite, one{{place}}",
            f"a time step too large is the likely cause (it was {1e6 * dt:.1f} us)",
            "let the step be chosen, or give a smaller cfl", float(count), 0.0,
        )  # fmt: skip
        return alarm.at(place + (self.section.shift, 0.0), point)

    def inside(self, points: dict[str, np.ndarray]) -> np.ndarray:
        """Which of `points()` are finite and within the grid less its margin."""
        return self._within(points, self.scene.silo.width_m)

    def _within(self, points: dict[str, np.ndarray], width_m: float) -> np.ndarray:
        place = points["position"] - np.array([0.0, self.origin_m])
        top = np.array([width_m + self.grid.cell_size, (self.grid.rows - 2 * MARGIN) * self.grid.cell_size])
        return ((place > -self.grid.cell_size) & (place < top)).all(axis=1) & np.isfinite(points["stress"]).all(axis=1)
