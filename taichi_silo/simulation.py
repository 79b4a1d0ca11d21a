"""From a scene to its history: fill the silo, let it settle, lower the bottom."""

import math
import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from taichi_silo.averaging import NonLocal
from taichi_silo.column import wave_speed_of
from taichi_silo.faults import RunFailed
from taichi_silo.grid import MARGIN, Grid
from taichi_silo.half import HalfSolver
from taichi_silo.noise import NoiseControl
from taichi_silo.particles import Particles
from taichi_silo.runtime import threads
from taichi_silo.scene import Scene
from taichi_silo.shapes import SHAPES
from taichi_silo.solver import Solver
from taichi_silo.symmetry import half_model, whole_points, whole_profile
from taichi_silo.walls import Coulomb, Glide, NoSlip, PlaneWall
from taichi_silo.weaknesses import weaknesses

LEFT, RIGHT, BOTTOM = 0, 1, 2
RAMP_PERIODS = 5  # the bottom reaches its speed over so many periods
HEADROOM = 0.1  # of the fill height, free above it; more where sand hangs on a very rough wall while the grid sinks
SHORTEST_FILLING_PERIODS = 12  # the weight must not grow faster than the column can follow
LONGEST_SETTLING_PERIODS = 20  # at least
STEP_SAFETY = 0.95  # of the stable step, which changes within an interval
FIRST_STEP = 0.2  # of the stable step of unstressed sand: in the first interval the stress grows a thousandfold
SETTLED = 2e-4  # relative change of the wall force over two periods that counts as rest


@dataclass(frozen=True)
class Record:
    """One interval: forces are means over it, so no impulse is lost between records; state is at its end.

    Signs: normals positive in compression, shears positive where the wall carries weight; per metre run.
    """

    time_s: float
    stage: str  # "filling" or "flow"
    displacement_m: float
    interval_s: float
    bottom_N_per_m: float
    left_normal_N_per_m: float
    left_shear_N_per_m: float
    right_normal_N_per_m: float
    right_shear_N_per_m: float
    weight_N_per_m: float
    momentum_rate_N_per_m: float  # of the vertical momentum
    control_N_per_m: float  # vertical force of the noise control on the sand
    kinetic_energy_J_per_m: float
    time_step_s: float
    stable_step_s: float
    void_ratio_low: float
    separated: int  # points that carry no stress
    strays: int
    speed_m_per_s: float
    profile: np.ndarray  # (3 walls, slots, 2): force of the wall on the sand at each node [N/m]

    @property
    def normal_N_per_m(self) -> float:
        """N: mean of both walls."""
        return 0.5 * (self.left_normal_N_per_m + self.right_normal_N_per_m)

    @property
    def shear_N_per_m(self) -> float:
        """T: mean of both walls."""
        return 0.5 * (self.left_shear_N_per_m + self.right_shear_N_per_m)

    @property
    def wall_friction_angle_deg(self) -> float:
        """Arctan(T / N)."""
        return math.degrees(math.atan2(self.shear_N_per_m, self.normal_N_per_m))

    @property
    def residual_N_per_m(self) -> float:
        """P + 2 T - W - d(upward momentum)/dt + control force: zero but for round-off."""
        carried = self.bottom_N_per_m + self.left_shear_N_per_m + self.right_shear_N_per_m
        return carried - self.weight_N_per_m - self.momentum_rate_N_per_m + self.control_N_per_m


def noise_control(scene: Scene, period_s: float) -> NoiseControl:
    """As the scene asks for, scaled to the period of its column."""
    if scene.method.noise_control == "none":
        return NoiseControl()
    return NoiseControl.for_column(period_s, scene.silo.height_m / scene.silo.width_m)


def headroom(scene: Scene) -> float:
    """Height of the grid above the fill [m]."""
    return max(HEADROOM * scene.silo.height_m, scene.flow.displacement_m + 2.0 * scene.grid.cell_size_m)


class Simulation:
    """The silo of a scene, ready to be filled; Taichi has been started.

    Iterate over `run()`: it yields a `Record` after each interval. Observers look at the public attributes in between.
    """

    def __init__(self, scene: Scene, control: NoiseControl | None = None, lanes: bool | None = None):
        self.scene = scene
        self.warnings = weaknesses(scene)  # sentences on what is known, and what observers find
        # mass scaling: heavier grains under a smaller gravity have the same weight
        self.law = scene.law
        self.gravity = scene.method.gravity_m_per_s2 / scene.method.mass_scaling
        self.density = self.law.grain_density / (1.0 + scene.sand.void_ratio)  # inertial
        self.time, self.displacement, self.stage = 0.0, 0.0, "filling"
        self.settled = False  # whether the wall force had come to rest before the flow
        self.flow_start, self.bottom_speed = None, 0.0  # [s], [m/s]
        self.steps, self.stepping_seconds = 0, 0.0
        self.after, self.seen = None, None  # last survey, and of which points
        h = scene.grid.cell_size_m
        per_axis = math.isqrt(scene.grid.points_per_cell)
        self.spacing = h / per_axis

        self.shape = SHAPES[scene.grid.shape](0.5 / per_axis)
        self.transfer = scene.method.transfer_of_points()

        self.wave_speed = wave_speed_of(scene)
        self.period = 4.0 * scene.silo.height_m / self.wave_speed
        self.rows_per_period = scene.output.records_per_period
        self.control = noise_control(scene, self.period) if control is None else control

        self.half, _ = half_model(scene)
        self.whole = 2.0 if self.half else 1.0  # silo over what is computed of it
        self.width = scene.silo.width_m / self.whole  # of what is computed [m]
        self.columns = round(scene.silo.width_m / h) + 1 + 2 * MARGIN  # nodes across the silo

        grid = Grid(self.width, scene.silo.height_m + headroom(scene), h, copies=threads())
        self.particles = self._fill_box()
        kernel, self.about_averaging = scene.averaging.kernel(scene.sand, self.spacing)
        self.solver = (HalfSolver if self.half else Solver)(
            self.particles, grid, self.shape, self.law, self._walls(grid), self.control,
            averaging=NonLocal(kernel, self.particles, self.spacing) if kernel else None,
            lanes=lanes if scene.machine.lanes else False, **scene.method.solver_options(),
        )  # fmt: skip
        if why := self.solver.distrust:
            slower = "Steps take two to four times as long."
            self.warnings.append(f"The processor's vector unit is not used: {why}. {slower}")
        self.mass = self.whole * float(self.particles.mass.to_numpy().sum())
        self.solver.advance(0, 1.0)  # compiles

    def _fill_box(self) -> Particles:
        scene, d = self.scene, self.spacing
        columns, rows = round(self.width / d), round(scene.silo.height_m / d)
        x, y = np.meshgrid((np.arange(columns) + 0.5) * d, (np.arange(rows) + 0.5) * d)
        count = columns * rows
        particles = Particles(count, Particles.extras(self.law, self.shape, self.transfer))
        state = {
            "position": np.stack([x.ravel(), y.ravel()], axis=1),
            "velocity": np.zeros((count, 2)),
            "stress": np.tile([-self.law.rest_stress] * 3 + [0.0], (count, 1)),
            "mass": np.full(count, self.density * d * d),
            "volume": np.full(count, d * d),
            "path": np.zeros(count),
            "domain": np.tile([d, 0.0, 0.0, d], (count, 1)),
        }
        if self.law.REMEMBERS:  # the last strain is that of filling: vertical compression
            state["intergranular"] = np.tile([0.0, -self.law.radius, 0.0, 0.0], (count, 1))
        particles.load(state)
        return particles

    def _walls(self, grid: Grid) -> tuple[PlaneWall, ...]:
        scene = self.scene
        side = NoSlip() if scene.walls.kind == "very-rough" else Coulomb(scene.wall_friction_angle_deg)
        opposite = ("axis", Glide()) if self.half else ("right", side)
        return (
            PlaneWall("left", 0, -1, grid.node_along(0.0), side),
            PlaneWall(opposite[0], 0, 1, grid.node_along(self.width), opposite[1]),
            PlaneWall(
                "bottom", 1, -1, grid.node_along(0.0), Coulomb(scene.walls.bottom_friction_angle_deg), motion=(0.0, 1.0)
            ),
        )

    # --- stages ---------------------------------------------------------------------------------------------------

    @property
    def interval(self) -> float:
        """Time between records [s]."""
        return self.period / self.rows_per_period

    @property
    def filling_time(self) -> float:
        """Duration of the increase of weight [s]: as given, but no faster than the column can follow."""
        return max(self.scene.method.filling_time_s, SHORTEST_FILLING_PERIODS * self.period)

    def run(self):
        """Fill, settle and flow; yields a Record after each interval."""
        yield from self.fill()
        yield from self.flow()

    def fill(self):
        """Linear increase of weight, then rest until the wall force no longer changes."""
        self.stage = "filling"
        g = self.gravity
        duration = self.filling_time
        count = math.ceil(duration / self.interval)
        for number in range(count):
            yield self._interval(duration / count, (g * number / count, g * (number + 1) / count), (0.0, 0.0))
        recent = deque(maxlen=2 * self.rows_per_period)
        longest = max(self.scene.method.longest_settling_s, LONGEST_SETTLING_PERIODS * self.period)
        for _ in range(math.ceil(longest / self.interval)):
            record = self._interval(self.interval, (g, g), (0.0, 0.0))
            recent.append(record.normal_N_per_m)
            yield record
            still = max(recent) - min(recent) < SETTLED * max(recent)
            self.settled = bool(still and len(recent) == recent.maxlen)
            if self.settled:
                break

    def flow(self):
        """Lower the bottom: a smooth start over several periods, then constant speed."""
        self.stage = "flow"
        g, target = self.gravity, self.scene.flow.displacement_m
        start = self.flow_start = self.time
        while self.displacement < target * (1.0 - 1e-12):
            duration = self.interval
            faster = self._speed(self.time + duration - start)
            mean = 0.5 * (self.bottom_speed + faster)
            duration = min(duration, (target - self.displacement) / mean)
            yield self._interval(duration, (g, g), (-self.bottom_speed, -faster))
            self.bottom_speed = faster

    def _speed(self, since_start: float) -> float:
        part = min(since_start / (RAMP_PERIODS * self.period), 1.0)
        return self.scene.flow.speed_m_per_s * part * part * (3.0 - 2.0 * part)

    def _interval(self, duration: float, gravity, plate_velocity) -> Record:
        scene, solver = self.scene, self.solver
        before = self.after if self.seen == self.particles.loads else solver.survey()
        # while the weight grows so does the wave speed: stiffness goes with a power of the stress, the law's degree
        growth = (gravity[0] / gravity[1]) ** (0.5 * self.law.degree) if gravity[0] > 0.0 else FIRST_STEP
        step = scene.method.time_step(before, STEP_SAFETY) * (growth if scene.method.time_step_s is None else 1.0)
        steps = max(1, math.ceil(duration / step - 1e-9))
        dt = duration / steps
        filling = self.control.filling_drag if self.stage == "filling" else 0.0
        begun = time.perf_counter()
        solver.advance(steps, dt, gravity, plate_velocity, filling)
        reaction, control = solver.books.take()  # waits for the device
        self.stepping_seconds += time.perf_counter() - begun
        after = self.after = solver.survey()
        self.seen = self.particles.loads
        if after.strays:
            raise RunFailed(self._astray(after.strays, dt))
        self.time += duration
        self.displacement -= 0.5 * (plate_velocity[0] + plate_velocity[1]) * duration
        self.steps += steps
        profile = (whole_profile(reaction, self.columns) if self.half else reaction) / duration
        force = profile.sum(axis=1)
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
            weight_N_per_m=self.mass * 0.5 * (gravity[0] + gravity[1]),
            momentum_rate_N_per_m=self.whole * (after.momentum - before.momentum) / duration,
            control_N_per_m=self.whole * control[:, 1].sum() / duration,
            kinetic_energy_J_per_m=self.whole * after.kinetic_energy,
            time_step_s=dt,
            stable_step_s=after.stable_step,
            void_ratio_low=after.void_ratio_low,
            separated=int(self.whole) * after.separated,
            strays=after.strays,
            speed_m_per_s=after.speed,
            profile=profile,
        )

    # --- state ----------------------------------------------------------------------------------------------------

    def points(self) -> dict[str, np.ndarray]:
        """All fields of the points as arrays, `position` in the laboratory, and `void_ratio`; of the whole silo."""
        own = self._computed()
        return whole_points(own, self.scene.silo.width_m) if self.half else own

    def _computed(self) -> dict[str, np.ndarray]:
        arrays = self.particles.arrays()
        arrays["position"] = arrays["position"] - np.array([0.0, self.displacement])
        arrays["void_ratio"] = arrays["volume"] * self.law.grain_density / arrays["mass"] - 1.0
        return arrays

    def _astray(self, count: int, dt: float) -> str:
        points = self._computed()
        first = int(np.argmin(self._within(points, self.width)))
        x, y = points["position"][first]
        if not np.isfinite(x + y):  # where it is cannot be said, but where it was filled in
            across = round(self.width / self.spacing)
            x, y = (first % across + 0.5) * self.spacing, (first // across + 0.5) * self.spacing
        return (
            f"after t = {self.time:.4f} s ({self.stage}, u = {1e3 * self.displacement:.3f} mm) {count} points left the "
            f"silo or are not finite, one near x = {1e3 * x:.1f} mm, y = {1e3 * y:.1f} mm; a time step too large is "
            f"the likely cause (it was {1e6 * dt:.1f} us)"
        )

    def inside(self, points: dict[str, np.ndarray]) -> np.ndarray:
        """Which of `points()` are finite and within the grid less its margin."""
        return self._within(points, self.scene.silo.width_m)

    def _within(self, points: dict[str, np.ndarray], width_m: float) -> np.ndarray:
        grid = self.solver.grid
        place = points["position"] + np.array([0.0, self.displacement])
        top = np.array([width_m + grid.cell_size, (grid.rows - 2 * MARGIN) * grid.cell_size])
        return ((place > -grid.cell_size) & (place < top)).all(axis=1) & np.isfinite(points["stress"]).all(axis=1)
