"""The numbers of a scene with error bars, out of the runs of its ladder.

With f the result of a run, the effects of cells and of length add up step by step,

    g_k = sum of f(grid i) - f(main i-1),    l_k = sum of f(main i) - f(grid i),    i = 1 ... k

and each is extrapolated by itself: g to cells of no size, l to the scene's own length, s (at the higher speeds) to the
scene's own speed. The value is f(main K) plus the three rests, its error the root of the sum of their squares.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from taichi_silo.analysis.extrapolation import Limit, limit
from taichi_silo.studies.converge.ladder import Ladder
from taichi_silo.studies.converge.quantities import Quantity

LAST = 4  # steps that an extrapolation takes
CARRIED = 0.25  # of the correction of the speed, made at one cell size and used at another


@dataclass(frozen=True)
class Number:
    """A quantity of a scene: its value, half the width of the band that holds the truth, and where that comes from."""

    value: float
    error: float
    unit: str
    scale: float  # what `relative` is over; nan for the value
    computed: float  # of the finest run
    parts: Mapping[str, Limit]  # "grid", "length", "speed": of the sums g, l, s; "time": of the finest run

    @property
    def relative(self) -> float:
        """The error over its measure."""
        measure = self.value if math.isnan(self.scale) else self.scale
        return self.error / abs(measure) if measure else math.inf if self.error else 0.0

    @property
    def decisive(self) -> str:
        """The part that makes most of the error."""
        return max(self.parts, key=lambda name: _finite(self.parts[name].error), default="grid")

    @property
    def order(self) -> float | None:
        """Observed order of the part that makes most of the error."""
        return self.parts[self.decisive].order

    def as_json(self) -> dict:
        """For scripts; what is not known is null."""
        parts = {name: {"error": _or_none(one.error), "order": _or_none(one.order), "trust": one.trust}
                 for name, one in self.parts.items()}  # fmt: skip
        return {
            "value": self.value, "error": _or_none(self.error), "unit": self.unit, "order": _or_none(self.order),
            "relative_error": _or_none(self.relative), "computed": self.computed, "decisive": self.decisive,
            "parts": parts,
        }  # fmt: skip


def estimate(ladder: Ladder, steps: int, found: Mapping[str, Mapping[str, Quantity]]) -> dict[str, Number]:
    """All numbers of a scene, by their names, from the runs of so many steps.

    Parameters
    ----------
    ladder : of the scene.
    steps : that are done, at least one.
    found : what each run found, by its name.

    """
    finest = found[ladder.main(steps - 1).name]
    names = [name for name in finest if all(name in found[run] for step in range(steps) for run in ladder.step(step))]
    return {name: _number(ladder, steps, {run: one[name] for run, one in found.items() if name in one})
            for name in names}  # fmt: skip


def _number(ladder: Ladder, steps: int, found: Mapping[str, Quantity]) -> Number:
    """One quantity."""
    mains = [found[ladder.main(step).name] for step in range(steps)]
    grids = [found[ladder.grid(step).name] for step in range(1, steps)]
    effects: dict[str, list[float]] = {"grid": [0.0], "length": [0.0]}
    for before, between, now in zip(mains, grids, mains[1:], strict=False):
        effects["grid"].append(effects["grid"][-1] + between.value - before.value)
        effects["length"].append(effects["length"][-1] + now.value - between.value)
    cells, lengths = [ladder.cell(step) for step in range(steps)], [ladder.length(step) for step in range(steps)]
    parts = {
        "grid": limit(cells[-LAST:], effects["grid"][-LAST:]),
        "length": _of_length(lengths, effects["length"], ladder.aim_m),
    }
    rests = {name: one.value - effects[name][-1] for name, one in parts.items()}
    faster = [found[rung.name].value for rung in ladder.faster() if rung.name in found]
    if len(faster) == len(ladder.speeds) > 1:
        parts["speed"] = limit(ladder.speeds, faster, ladder.scene.flow.speed_m_per_s)
        rests["speed"] = parts["speed"].value - faster[-1]
    last = mains[-1]
    if last.unsteady:
        parts["time"] = Limit(last.value, last.unsteady, None, "as it still changes")
    carried = CARRIED * rests.get("speed", 0.0)
    error = math.hypot(carried, *(one.error for one in parts.values()))
    return Number(last.value + sum(rests.values()), error, last.unit, last.scale, last.value, parts)


def _of_length(lengths: list[float], effects: list[float], aim: float) -> Limit:
    """The limit of the effect of the length, of which steps that share one length tell nothing new."""
    different = [number for number, one in enumerate(lengths) if number == 0 or one < lengths[number - 1]]
    if aim >= lengths[0]:
        return Limit(effects[-1], 0.0, None, "exact")
    return limit(
        [lengths[number] for number in different][-LAST:], [effects[number] for number in different][-LAST:], aim
    )


def _finite(value: float) -> float:
    return math.inf if math.isnan(value) else value


def _or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
