"""How the sand gets into the silo: its weight grows, or it comes in layers, or as rain.

Each way is a generator of records over a simulation; `fill` ends with a rest until the wall force no longer changes.
What a way knows at a record is in the simulation's `Progress`, so it can be left there and entered again.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from taichi_silo.simulation.discretise import load

SHORTEST_PERIODS = 12  # the weight must not grow faster than the column can follow
LONGEST_SETTLING_PERIODS = 20  # at least
SETTLED = 2e-4  # relative change of the wall force over two periods that counts as rest
FIRST_STEP = 0.2  # of the stable step of unstressed sand: in the first interval the stress grows a thousandfold
SECOND_STEP = 0.5  # of what the weight alone would allow: the first swing overshoots it
LONGER = 1.5  # at most, a step against that of the interval before, while layers come: their first swing stiffens them
LANDING = 0.4  # of the stable step while rain falls: what lands is stiff at once
LAYER_PERIODS = 1.0  # of the whole column, between two layers
RISE_PERIODS = 60.0  # of the whole column, that rain takes


@dataclass
class Progress:
    """How far a filling has come.

    Attributes
    ----------
    intervals : that the way of filling has taken.
    rest : intervals since then.
    forces : N at the end of the last of these, over two periods at most [N/m].

    """

    intervals: int = 0
    rest: int = 0
    forces: list[float] = field(default_factory=list)


def duration(scene, period: float) -> float:
    """Of the filling of a column with this period, without the rest after it [s]."""
    if scene.filling.kind == "layers":
        return scene.filling.layers * LAYER_PERIODS * period
    if scene.filling.kind == "rain":
        return RISE_PERIODS * period + fall_time(scene)
    return max(scene.method.filling_time_s, SHORTEST_PERIODS * period)


def fall_time(scene) -> float:
    """Of rain [s]."""
    return math.sqrt(2.0 * scene.filling.drop_m * scene.method.mass_scaling / scene.method.gravity_m_per_s2)


def fill(simulation):
    """Fill and settle, from where the simulation is on; yields a Record after each interval."""
    way = {"gravity-ramp": gravity_ramp, "layers": layers, "rain": rain}[simulation.scene.filling.kind]
    for record in way(simulation, simulation.filling.intervals):
        simulation.filling.intervals += 1
        yield record
    yield from settle(simulation)


def first_step(simulation, stress_Pa: float) -> float:
    """Of the stable step of unstressed sand, for an interval in which the stress grows to this: as waves get faster."""
    growth = (simulation.law.rest_stress / max(stress_Pa, simulation.law.rest_stress)) ** (0.5 * simulation.law.degree)
    return min(FIRST_STEP, 0.5 * growth)


def gravity_ramp(simulation, begun: int):
    """All sand is there; its weight grows linearly."""
    g, whole = simulation.gravity, duration(simulation.scene, simulation.period)
    count = math.ceil(whole / simulation.interval)
    weight = simulation.density * simulation.scene.silo.height_m
    for number in range(begun, count):
        low, high = g * number / count, g * (number + 1) / count
        # while the weight grows so does the wave speed: stiffness goes with a power of the stress, the law's degree
        growth = (low / high) ** (0.5 * simulation.law.degree) if number else first_step(simulation, weight * high)
        growth = SECOND_STEP * growth if number == 1 else growth
        yield simulation.advance(whole / count, (low, high), growth=growth)


def layers(simulation, begun: int):
    """One layer after the other, without stress at first, each with its whole weight at once."""
    height = simulation.fill_state["position"][:, 1]
    count = simulation.scene.filling.layers
    number = np.minimum((height / (height.max() + 1e-9) * count).astype(int), count - 1)
    number = np.unique(number, return_inverse=True)[1]  # no layer is empty
    pause = LAYER_PERIODS * simulation.period
    yield from _portions(simulation, begun, number, pause, 0.0)


def rain(simulation, begun: int):
    """Row after row falls from a height onto the sand that is there."""
    height = simulation.fill_state["position"][:, 1]
    rows = np.unique(np.round(height / simulation.spacing, 6))
    number = np.searchsorted(rows, np.round(height / simulation.spacing, 6))
    drop = simulation.scene.filling.drop_m
    pause = RISE_PERIODS * simulation.period / len(rows)
    yield from _portions(simulation, begun, number, pause, drop)
    falling = simulation.filling.intervals - len(rows) * _intervals(simulation, pause)  # since the last row began to
    for _ in range(falling, math.ceil(fall_time(simulation.scene) / simulation.interval)):
        yield simulation.advance(simulation.interval, growth=LANDING)


def _intervals(simulation, pause: float) -> int:
    """Between two portions."""
    return max(1, math.ceil(pause / simulation.interval - 1e-9))


def _portions(simulation, begun: int, number: np.ndarray, pause: float, above: float):
    """The portions of the fill, numbered by point, one after the other, so far above their place [m]."""
    thick = simulation.density * simulation.gravity * (above + simulation.scene.silo.height_m / (1.0 + number.max()))
    intervals = _intervals(simulation, pause)
    for interval in range(begun, (1 + int(number.max())) * intervals):
        portion, part = divmod(interval, intervals)
        if part == 0:
            _pour(simulation, np.flatnonzero(number == portion), above)
        growth = LANDING if above else 1.0
        if interval == 0:
            growth = min(growth, first_step(simulation, 2.0 * thick))
        yield simulation.advance(pause / intervals, growth=growth, longer=math.inf if above else LONGER)


def _pour(simulation, chosen: np.ndarray, above: float) -> None:
    """Points of the fill, chosen by their numbers, so far above their place [m], onto what is there."""
    particles, fill_state = simulation.particles, simulation.fill_state
    new = {name: values[chosen] for name, values in fill_state.items()}
    new["position"] = new["position"] + (0.0, above)
    first = simulation.filling.intervals == 0  # until then the whole fill is loaded
    there = {name: values[:0] for name, values in fill_state.items()} if first else particles.arrays()
    if "affine" in there:
        new["affine"] = np.zeros((len(new["mass"]), 4))
    load(particles, {name: np.concatenate([there[name], new[name]]) for name in there})
    simulation.identity = np.concatenate([simulation.identity[: len(there["mass"])], chosen])


def settle(simulation):
    """Rest until the wall force no longer changes."""
    done, span = simulation.filling, 2 * simulation.rows_per_period
    longest = max(simulation.scene.method.longest_settling_s, LONGEST_SETTLING_PERIODS * simulation.period)
    while done.rest < math.ceil(longest / simulation.interval) and not simulation.settled:
        record = simulation.advance(simulation.interval)
        done.rest, done.forces = done.rest + 1, [*done.forces, float(record.normal_N_per_m)][-span:]
        still = max(done.forces) - min(done.forces) < SETTLED * max(done.forces)
        simulation.settled = bool(still and len(done.forces) == span)
        yield record
