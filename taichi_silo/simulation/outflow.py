"""How the sand gets out: the bottom or a gate sinks at a given speed, the gate is opened, or a column collapses.

The next interval follows from the clock and the points, so the flow can be left at a record and gone on with.
"""

import math
from dataclasses import replace

import numpy as np

from taichi_silo.analysis.measure.surface_profile import SurfaceProfile
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.scene import cell_sizes, fill_shape, known_limits
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation import gates
from taichi_silo.simulation.clock import OPENED, Clock, Interval
from taichi_silo.simulation.model import Model

RAMP_PERIODS = 5  # the bottom reaches its speed over so many periods, or longer:
GENTLY = 0.01  # of gravity, its largest acceleration; with the drag of the noise control it takes 0.02 off the weight
SHORT, LANDING = 0.5, 0.6  # of an interval and of a time step in free outflow: sand that lands is stiff at once
LONGER = 1.05  # at most, a step against that of the interval before: where sand has landed, more will
REACH = 0.35  # of a cell: by more, no sand may pass the exit within an interval
SAME_TIME_S = 1e-9  # nearer times are one
AT_REST_S = 0.25  # without outflow, after which a free flow has stopped; longer by the root of a mass scaling
STEEPEST = 1.5  # largest slope of the start, over its mean
PARTS = 1001  # of the start, in which its displacement is looked up
OVER = 0.25  # of the outlet's width, to both sides of its middle: no sand that has flowed freely stays there
FOLLOWS = 0.5  # of what a gate makes room for: where less has left, the sand bridges the outlet
JAMMED, LAGS = "The flow has jammed", "The sand lags behind"  # begin of the sentences on it
STUCK = 1.0 / 3.0  # of a gate's way: sand that has not moved on for so long has jammed,
NOTHING = 0.1  # that is by less than so much of what the gate makes room for
STILL = 0.002  # of the root of g H: mean speed below which a collapsed column rests,
RESTING = 1.0  # if it lasts for so many times the fall of the column, root of H / g
OF_FALL = 0.01  # of that fall, an interval of a collapse
SWEPT = 3.0  # times within that fall points relax to the grid: h^2 / 4 of it each, a viscosity the collapse outruns


def duration(scene: Scene, period: float) -> float:
    """Of the flow of a column with this period, at most [s]."""
    flow = scene.flow
    if flow.free:
        return flow.longest_s
    begun, steady = start(scene, period), flow.displacement_m / flow.speed_m_per_s
    if steady >= 0.5 * begun:
        return steady + 0.5 * begun
    part = np.linspace(0.0, 1.0, PARTS)
    return begun * float(np.interp(steady / begun, part**3 - 0.5 * part**4, part))


def reached_m_per_s(scene: Scene) -> float:
    """The speed up to which the bottom of a scene has reached it within half of the displacement."""
    method = scene.method
    gently = GENTLY * method.gravity_m_per_s2 / method.mass_scaling
    return math.sqrt(scene.flow.displacement_m * gently / STEEPEST)


def start(scene: Scene, period: float) -> float:
    """Time in which the bottom or the gate of a column with this period reaches its speed [s]."""
    method = scene.method
    gently = STEEPEST * scene.flow.speed_m_per_s * method.mass_scaling / (GENTLY * method.gravity_m_per_s2)
    return max(RAMP_PERIODS * period, gently)


def control(model: Model) -> NoiseControl:
    """The noise control in flow: of free outflow only its relaxation, as its drag would brake what accelerates."""
    if model.scene.flow.outflow == "collapse" and model.control.drag:
        return NoiseControl(relaxation=min(model.control.relaxation, SWEPT / _fall(model)))
    if model.scene.flow.free and model.control.drag:
        return NoiseControl(relaxation=model.control.relaxation)
    return model.control


def next_interval(model: Model, clock: Clock, fastest_m_per_s: float) -> Interval | None:
    """The next interval of the flow that the scene asks for, None at its end; the fastest point has this speed."""
    free = model.scene.flow.free
    interval = _free(model, clock, fastest_m_per_s) if free else _controlled(model, clock)
    if interval is None or model.gates is None or clock.flow_start is None:
        return interval
    since = clock.time - clock.flow_start
    if free:  # gates are open or closed, and intervals end when that changes
        change = gates.next_change(model.openings, since + SAME_TIME_S) - since
        moved = gates.shares(model.openings, since + SAME_TIME_S, 0.0)
        return replace(interval, duration=min(interval.duration, change), gates=moved)
    middle = since + 0.5 * interval.duration
    return replace(interval, gates=gates.shares(model.openings, middle, start(model.scene, model.period)))


def bottom_speed(model: Model, since_start_s: float) -> float:
    """Of the bottom or the gate, downwards [m/s]: a smooth start, then constant."""
    part = min(since_start_s / start(model.scene, model.period), 1.0)
    return model.scene.flow.speed_m_per_s * part * part * (3.0 - 2.0 * part)


def _controlled(model: Model, clock: Clock) -> Interval | None:
    """Lower the bottom or the gate until it has reached its displacement."""
    target = model.scene.flow.displacement_m
    if clock.flow_start is None or clock.displacement >= target * (1.0 - 1e-12):
        return None
    speed = bottom_speed(model, clock.time - clock.flow_start)
    faster = bottom_speed(model, clock.time + model.interval - clock.flow_start)
    duration = min(model.interval, (target - clock.displacement) / (0.5 * (speed + faster)))
    return Interval(duration, plate_velocity=(-speed, -faster))


def why_ended(model: Model, clock: Clock) -> str:
    """Why a free outflow ends now: "empty", "enough", "time" or "rest"; empty while it goes on."""
    flow = model.scene.flow
    if not model.particles.number:
        return "empty"
    if clock.displacement >= flow.displacement_m:
        return "enough"
    if clock.flow_start is None or clock.time >= clock.flow_start + flow.longest_s:
        return "time"
    since = clock.time - clock.flow_start
    if gates.more_to_open(model.openings, since):
        return ""
    last = clock.flow_start + gates.last_opening(model.openings, since)
    return "rest" if clock.time - max(clock.left_at, last) >= _rest(model) else ""


def jam(model: Model, left_share: float) -> str:
    """What to say of a free outflow that has come to rest: a sentence if sand stands over the middle of the outlet."""
    if not _bridged(model):
        return ""
    return f"{JAMMED}: {left_share:.0%} of the sand stays in the silo and bridges the outlet; {_advice(model)}."


def lags(model: Model, clock: Clock, left_kg_per_m: float, since_kg_per_m: float) -> tuple[str, bool]:
    """What to say of gates after so much has left: a sentence if the sand did not follow, and whether it has jammed.

    `since_kg_per_m` : what has left since `clock.left_at`.
    Nothing is said of gates with times of their own, which have not all sunk as far.
    """
    scene, silo, sunk_m = model.scene, model.scene.silo, clock.displacement
    timed = any(outlet.timed for outlet in silo.outlets)
    if timed or not known_limits.has_pattern(scene, sunk_m):
        return "", False
    room = model.density * silo.outlet_share_m
    share = left_kg_per_m / (room * sunk_m)
    if share >= FOLLOWS or not _bridged(model):
        return "", False
    told = f"the gate has sunk by {1e3 * sunk_m:.3g} mm, and {share:.0%} of the sand that it made room for has left; "
    way = scene.flow.speed_m_per_s * (clock.time - clock.left_at)
    if way >= STUCK * sunk_m and since_kg_per_m < NOTHING * room * way:
        return f"{JAMMED}: {told}the rest bridges the outlet; {_advice(model)}.", True
    return f"{LAGS}: {told}{_advice(model)}.", False


def _bridged(model: Model) -> bool:
    """Whether sand stands over the middle of the outlet."""
    scene = model.scene
    edges = [edge - model.section.shift for edge in scene.silo.outlet_m]
    middle, reach = 0.5 * sum(edges), OVER * (edges[1] - edges[0])
    x, y = model.particles.array("position").T
    return bool(((np.abs(x - middle) <= max(reach, 0.51 * model.spacing)) & (y > 0.0)).any())


def _advice(model: Model) -> str:
    """What lets sand flow that has jammed."""
    scene = model.scene
    cells = known_limits.cells_across_outlet(scene)
    if cells < known_limits.FEWEST_CELLS - 1e-6:
        size = 1e3 * scene.grid.cell_size_m * cells / known_limits.FEWEST_CELLS
        return f"the outlet is {cells:.3g} cells wide, and smaller cells ({size:.3g} mm) or a wider outlet help"
    if scene.silo.inserts:
        gap, between = min(known_limits.gaps(scene.silo), default=(math.inf, ""))
        if gap < cell_sizes.narrowest_m(scene.silo):
            return f"the gap of {1e3 * gap:.3g} mm between {between} is narrower than the outlet; a wider one helps"
    return "a wider outlet or smoother walls let it flow"


def _free(model: Model, clock: Clock, fastest_m_per_s: float) -> Interval | None:
    """Let the sand move until it has stopped, enough has left or a front has run far enough, or the time is over."""
    if why_ended(model, clock):
        return None
    if model.scene.flow.outflow == "collapse":
        return Interval(OF_FALL * _fall(model), plate_velocity=(OPENED, OPENED), growth=LANDING, longer=LONGER)
    reach = REACH * model.scene.grid.cell_size_m
    fastest = fastest_m_per_s + model.gravity * model.interval
    duration = min(SHORT * model.interval, reach / fastest)
    return Interval(duration, plate_velocity=(OPENED, OPENED), growth=LANDING, longer=LONGER)


def _rest(model: Model) -> float:
    """How long nothing may move, or leave, before the flow is over [s]."""
    if model.scene.flow.outflow == "collapse":
        return RESTING * _fall(model)
    return AT_REST_S * math.sqrt(model.scene.method.mass_scaling)


def _fall(model: Model) -> float:
    """Root of H / g [s]."""
    return math.sqrt(model.scene.silo.height_m / model.gravity)


def spreads(model: Model, kinetic_energy_J_per_m: float) -> bool:
    """Whether the sand of a column still moves, by its kinetic energy (that of the computed part)."""
    mass = model.mass / model.section.factor
    speed = STILL * math.sqrt(model.gravity * model.scene.silo.height_m)
    return kinetic_energy_J_per_m > 0.5 * mass * speed**2


def run_out(model: Model) -> float:
    """How far the farther front of a column has run [m]."""
    section, d = model.section, model.spacing
    x, area = model.particles.array("position")[:, 0], model.particles.array("volume")
    area = area / section.geometry.depth(x)
    profile = SurfaceProfile.of(x, area, d, 0.0, section.width, round(section.width / d))
    left, right = (side - section.shift for side in fill_shape.sides_m(model.scene.silo))
    middle = min(max(0.5 * (left + right), 0.5 * d), section.width - 0.5 * d)
    first, last = profile.fronts_m(middle)
    free = fill_shape.free_walls(model.scene.silo)
    computed = free[0] and left > 0.0, free[1] and right < section.width
    return max(0.0, left - first if computed[0] else 0.0, last - right if computed[1] else 0.0)
