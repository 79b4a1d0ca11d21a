"""How the sand gets into the silo: its weight grows, or it comes in layers, or as rain; then it rests.

A way of filling is a sequence of intervals that is known from the start, so it can be entered at any of them.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from taichi_silo.scene.scene import Scene
from taichi_silo.simulation.clock import Interval
from taichi_silo.simulation.model import Model

SHORTEST_PERIODS = 28  # the weight must not grow faster than the column can follow: N then errs by 0.3 % (Hostun sand)
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
    """How far a filling has come; a checkpoint keeps it as a dictionary.

    Attributes
    ----------
    intervals : that the way of filling has taken.
    rest : intervals since then.
    forces : N at the end of the last of these, over two periods at most [N/m].

    """

    intervals: int = 0
    rest: int = 0
    forces: list[float] = field(default_factory=list)

    def at_rest(self, normal_N_per_m: float, intervals: int) -> bool:
        """Take down N of an interval of rest; whether it has not changed over so many of them."""
        self.rest += 1
        self.forces = [*self.forces, normal_N_per_m][-intervals:]
        still = max(self.forces) - min(self.forces) < SETTLED * max(self.forces)
        return still and len(self.forces) == intervals


def duration(scene: Scene, period: float) -> float:
    """Of the filling of a column with this period, without the rest after it [s]."""
    if scene.filling.kind == "layers":
        return scene.filling.layers * LAYER_PERIODS * period
    if scene.filling.kind == "rain":
        return RISE_PERIODS * period + fall_time(scene)
    return max(scene.method.filling_time_s, SHORTEST_PERIODS * period)


def fall_time(scene: Scene) -> float:
    """Of rain [s]."""
    return math.sqrt(2.0 * scene.filling.drop_m * scene.method.mass_scaling / scene.method.gravity_m_per_s2)


def longest_rest(scene: Scene, period: float) -> float:
    """Time after which the flow begins even if the wall force still changes [s]."""
    return max(scene.method.longest_settling_s, LONGEST_SETTLING_PERIODS * period)


def intervals(model: Model, done: int) -> Iterator[Interval]:
    """The intervals of the way of filling that the scene asks for, after the first `done`."""
    way = {"gravity-ramp": gravity_ramp, "layers": layers, "rain": rain}[model.scene.filling.kind]
    return way(model, done)


def first_step(model: Model, stress_Pa: float) -> float:
    """Of the stable step of unstressed sand, for an interval in which the stress grows to this: as waves get faster."""
    growth = (model.law.rest_stress / max(stress_Pa, model.law.rest_stress)) ** (0.5 * model.law.degree)
    return min(FIRST_STEP, 0.5 * growth)


def grown(part: float) -> float:
    """Share of the weight at a share of the filling time.

    Neither its rate nor the rate of that jumps, at the start or the end: a ramp with a kink sets the column swinging,
    and sand that has swung presses on the walls more than sand that was loaded steadily.
    """
    return part**3 * (10.0 - 15.0 * part + 6.0 * part**2)


def gravity_ramp(model: Model, done: int) -> Iterator[Interval]:
    """All sand is there; its weight grows smoothly."""
    count = math.ceil(model.filling_time / model.interval)
    weight = model.density * model.scene.silo.height_m
    for number in range(done, count):
        low, high = (model.gravity * grown(end / count) for end in (number, number + 1))
        # while the weight grows so does the wave speed: stiffness goes with a power of the stress, the law's degree
        growth = (low / high) ** (0.5 * model.law.degree) if number else first_step(model, weight * high)
        growth = SECOND_STEP * growth if number == 1 else growth
        yield Interval(model.filling_time / count, (low, high), growth=growth)


def layers(model: Model, done: int) -> Iterator[Interval]:
    """One layer after the other, without stress at first, each with its whole weight at once."""
    height, count = model.fill()["position"][:, 1], model.scene.filling.layers
    layer = np.minimum((height / (height.max() + 1e-9) * count).astype(int), count - 1)
    layer = np.unique(layer, return_inverse=True)[1]  # no layer is empty
    return _portions(model, done, layer, LAYER_PERIODS * model.period, 0.0)


def rain(model: Model, done: int) -> Iterator[Interval]:
    """Row after row falls from a height onto the sand that is there."""
    height = np.round(model.fill()["position"][:, 1] / model.spacing, 6)
    rows, row = np.unique(height, return_inverse=True)
    pause = RISE_PERIODS * model.period / len(rows)
    yield from _portions(model, done, row, pause, model.scene.filling.drop_m)
    falling = max(done - len(rows) * _intervals_of(model, pause), 0)  # since the last row began to
    for _ in range(falling, math.ceil(fall_time(model.scene) / model.interval)):
        yield Interval(model.interval, growth=LANDING, longer=LONGER)


def _intervals_of(model: Model, pause: float) -> int:
    """Number of intervals between two portions."""
    return max(1, math.ceil(pause / model.interval - 1e-9))


def _portions(model: Model, done: int, portion: np.ndarray, pause: float, above: float) -> Iterator[Interval]:
    """Portions of the fill, numbered by point, one after the other, so far above their place [m]."""
    count = 1 + int(portion.max())
    thick = model.density * model.gravity * (above + model.scene.silo.height_m / count)
    parts = _intervals_of(model, pause)
    for number in range(done, count * parts):
        growth = LANDING if above else 1.0
        if number == 0:
            growth = min(growth, first_step(model, 2.0 * thick))
        poured = np.flatnonzero(portion == number // parts) if number % parts == 0 else None
        yield Interval(pause / parts, growth=growth, longer=LONGER, poured=poured, above=above)
