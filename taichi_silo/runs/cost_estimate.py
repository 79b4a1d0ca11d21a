"""What a run will cost, said before it starts: steps from the waves in the sand, seconds a step from a short rehearsal.

The time step is a fraction of h / c, and c grows with a power of the stress, so the number of steps follows from the
greatest stress that the sand will carry. That stress is taken as a multiple of the overburden at half the height; the
multiples (`FILLED`, `FLOWING`) are of the wave speed, and were measured on dense and loose Karlsruhe sand, 50 to 2.5 mm
cells. The steps come out within 10 % on grids of 4 to 80 cells across, up to 25 % elsewhere. Where smooth walls
converge, at bodies and at edges of outlets, stresses are higher, the more so the finer the cells: with `CUT` and
`EDGES` steps come out within 20 % in hoppers of 15 and 45 degrees, beside an insert and above an outlet in a level
floor, on 20 to 5 mm cells.
"""

import contextlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.laws.stress_point import wave_speed
from taichi_silo.mpm.patch_filter import TURN
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.scene import fill_shape, memory_need
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation import filling, outflow
from taichi_silo.simulation.model import Model
from taichi_silo.simulation.simulation import STEP_SAFETY, Simulation
from taichi_silo.simulation.time_scales import period_of, wave_speed_of
from taichi_silo.utils.messages import counted

SETTLING_PERIODS = 5.0  # until the wall force rests, with noise control
FILLED = {"smooth": 1.15, "very-rough": 1.04}  # greatest wave speed over that at half the height, after filling
FLOWING = {"smooth": 1.16, "very-rough": 1.05}  # the same in flow; of very rough walls with 20 cells across
CUT = {"filled": 1.4, "flow": 1.65}  # where smooth walls cut cells
EDGES = 1.4  # in flow through an outlet in a level floor, between smooth walls
SHARPER = 0.12  # growth of the latter with each halving of the cells: shear zones get thinner, their stress higher
SHARPNESS = (0.85, 1.17)  # where that growth begins and ends
RESOLVED = 1.38  # factor of the latter where several points share a cell
REHEARSED_S = 0.4  # of stepping
FIRST_INTERVALS, FEWEST_INTERVALS = 3, 5  # of a rehearsal: those that compile and build lists, and those measured
TURNS = 5  # of the filter, that are measured
REHEARSED_POINTS = 20e6  # times steps in an interval of a rehearsal, at most: some two seconds
REHEARSED_SHARE = 0.03  # of a run's steps, at most, unless they are fewer than in those intervals
HOUR_S = 3600.0
START_S = 6.0  # of a process: Taichi's start and the compilation of the step


@dataclass(frozen=True)
class Cost:
    """Of a run: points, steps, and the seconds of stepping times the threads that share it."""

    points: int
    steps: int
    core_seconds: float

    threads: int = 1

    @property
    def seconds(self) -> float:
        """Of stepping, by the clock."""
        return self.core_seconds / self.threads

    def words(self) -> str:
        """What it is, in a line."""
        long = "" if self.seconds >= HOUR_S else " minutes"
        size = f"{counted(self.points, 'point')}, about {counted(self.steps, 'step')}"
        return f"{size}: some {clock(self.seconds)}{long} of stepping"

    @property
    def nanoseconds(self) -> float:
        """Of one point and step, on one core."""
        return 1e9 * self.core_seconds / (self.points * self.steps)


def clock(seconds: float) -> str:
    """Minutes and seconds, or from an hour on hours and minutes.

    >>> clock(65.0), clock(9000.0)
    ('1:05', '2:30 h')
    """
    if not math.isfinite(seconds):
        return "?"
    large = seconds >= HOUR_S
    whole, rest = divmod(round(seconds / 60.0 if large else seconds), 60)
    return f"{whole:d}:{rest:02d}{' h' if large else ''}"


def steps(scene: Scene) -> int:
    """Number of time steps of a run of this scene, filling and settling included; Taichi has been started."""
    method, law, c, period = scene.method, scene.law, wave_speed_of(scene), period_of(scene)
    interval = period / scene.output.records_per_period
    fraction = SHAPES[scene.grid.shape](0.5 / math.isqrt(scene.grid.points_per_cell)).stable_fraction
    fraction = STEP_SAFETY * fraction if method.cfl is None else method.cfl

    speed_of_flow = 0.0 if scene.flow.free else scene.flow.speed_m_per_s

    def count(span: float, wave: float) -> int:
        """Steps of one interval."""
        step = method.time_step_s or fraction * scene.grid.cell_size_m / (wave + speed_of_flow)
        return max(1, math.ceil(span / step - 1e-9))

    whole = filling.duration(scene, period)
    rows = math.ceil(whole / interval)
    cut = scene.walls.kind == "smooth" and scene.silo.cuts_cells
    loaded = (CUT["filled"] if cut else FILLED.get(scene.walls.kind, FILLED["very-rough"])) * c
    growing = [loaded * filling.grown((row + 1) / rows) ** (0.5 * law.degree) for row in range(1, rows)]
    unstressed = wave_speed(
        law, (-law.rest_stress, -2.0 * law.rest_stress, -law.rest_stress, 0.0), scene.sand.void_ratio
    )
    found = count(whole / rows, unstressed / filling.FIRST_STEP)
    found += sum(count(whole / rows, wave) for wave in growing)
    settling = longest = filling.longest_rest(scene, period)
    if method.stress_update == "last" and (method.noise_control != "none" or scene.walls.kind != "smooth"):
        settling = min(SETTLING_PERIODS * period, longest)  # the wall force comes to rest
    found += round(settling / interval) * count(interval, loaded)
    wave = c * _sharpness(scene)
    if scene.flow.free:  # shorter steps, as sand that lands is stiff at once
        interval, wave = outflow.SHORT * interval, wave / outflow.LANDING
    return found + round(outflow.duration(scene, period) / interval * count(interval, wave))


def _sharpness(scene: Scene) -> float:
    """Greatest wave speed in flow, over that at half the height."""
    found = FLOWING.get(scene.walls.kind, FLOWING["very-rough"])
    if scene.walls.kind == "smooth":
        if scene.silo.cuts_cells:
            return CUT["flow"]
        return EDGES if scene.silo.has_opening and not scene.flow.free else found
    across = scene.silo.width_m / scene.grid.cell_size_m
    if scene.grid.points_per_cell > 1:
        return RESOLVED * found
    return min(max(found + SHARPER * math.log2(across / 20.0), SHARPNESS[0]), SHARPNESS[1])


def rehearse(simulation: Simulation, seconds: float = REHEARSED_S, most: float = math.inf) -> float:
    """Seconds that one step takes, from some steps of flow out of a geostatic state; the simulation is left as it was.

    Parameters
    ----------
    simulation : not yet begun.
    seconds, most : how long to measure, and how many steps; at least five intervals between records are.

    """
    model, solver = simulation.model, simulation.solver
    solver.executor.rest()
    model.particles.load(_at_rest(model, model.fill()))
    speed = 0.0 if model.scene.flow.free else model.scene.flow.speed_m_per_s  # the gate stays shut
    rates: list[float] = []
    timer = _timer(model.scene)
    end, begun, done = 0.0, 0, 0
    with contextlib.suppress(RunFailed):  # a run that cannot go on will say so itself
        while len(rates) < FEWEST_INTERVALS or (time.monotonic() < end and done < most):
            if begun == FIRST_INTERVALS:
                end, done = time.monotonic() + seconds, 0
            sums = solver.point_sums()
            if sums.strays:
                break
            step = model.scene.method.time_step(sums, STEP_SAFETY)
            count = max(1, math.ceil(model.interval / step - 1e-9))
            started = timer()
            gravity = model.gravity, model.gravity
            taken = min(count, max(1, int(REHEARSED_POINTS / model.particles.count)))
            solver.advance(taken, model.interval / count, gravity, (-speed if begun else 0.0, -speed))
            solver.impulses.read_and_reset()  # waits for the device
            begun, done = begun + 1, done + taken
            if begun > FIRST_INTERVALS:
                rates.append((timer() - started) / taken)
    solver.executor.rest()
    model.particles.load(model.fill())
    put(model.grid.memory, 0.0)
    solver.surfaces.clear()
    solver.impulses.read_and_reset()
    return float(np.quantile(rates, 0.25)) if rates else math.nan  # other programs interrupt some


def _at_rest(model: Model, points: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Fields of the points of the full silo under the stress of their own weight."""
    scene = model.scene
    x, y = (points["position"] + (model.section.shift, 0.0)).T
    depth = np.maximum(fill_shape.top_m(scene.silo, x) - y, 0.0)
    vertical = -scene.density_kg_per_m3 * scene.method.gravity_m_per_s2 * depth
    side = scene.law.rest_pressure_ratio(scene.sand.void_ratio) * vertical
    stress = np.minimum(np.stack([side, vertical, side, 0.0 * side], axis=1), points["stress"])
    stress[:, 3] = 0.0
    return points | {"stress": stress}


def at_pace(scene: Scene, seconds: float) -> Cost:
    """The cost of a run at a known pace, in seconds of one core for a point and step; Taichi has been started."""
    number = steps(scene)
    return Cost(scene.points, number, seconds * scene.points * number)


def before_start(scene: Scene) -> Cost:
    """The cost of a scene's run, on the machine that it names, which is started.

    Raises BadInput if it cannot be used, or has not the memory.
    """
    memory_need.check(scene)
    scene.machine.start()
    return predict(Simulation(scene))


def predict(simulation: Simulation) -> Cost:
    """The cost of a run, before it starts."""
    scene = simulation.scene
    number = steps(scene)
    seconds = number * rehearse(simulation, most=REHEARSED_SHARE * number)
    if (
        scene.flow.free and simulation.solver.filter.BETWEEN_LAUNCHES
    ):  # which turns by the way, and sand at rest has none
        seconds += turns(scene) * seconds_of_a_turn(simulation)
    return Cost(scene.points, number, seconds * runtime.threads(), runtime.threads())


def turns(scene: Scene) -> float:
    """How often the filter turns in free outflow: once a share of a cell that the fastest point goes.

    That one falls from the arch over the outlet, half a width above it, or of a column from its top.
    """
    silo = scene.silo
    height = silo.height_m if silo.column_m is not None else 0.5 * max(one.width for one in silo.openings)
    speed = math.sqrt(2.0 * scene.method.gravity_m_per_s2 * height)
    way = speed * outflow.duration(scene, period_of(scene))
    return way / (TURN * scene.grid.cell_size_m)


def seconds_of_a_turn(simulation: Simulation) -> float:
    """Of the filter, on the points of the full silo; the simulation is left as it was."""
    model, solver, timer = simulation.model, simulation.solver, _timer(simulation.scene)
    model.particles.load(_at_rest(model, model.fill()))
    solver.filter.begin()
    taken = []
    for _ in range(1 + TURNS):  # the first compiles
        started = timer()
        solver.filter.turn()
        solver.point_sums()  # waits for the device
        taken.append(timer() - started)
    model.particles.load(model.fill())
    return float(np.median(taken[1:]))


def _timer(scene: Scene) -> Callable[[], float]:
    """Of one thread its own time, which other programs on the machine do not lengthen."""
    machine = scene.machine
    return time.process_time if machine.arch == "cpu" and machine.threads == 1 else time.perf_counter
