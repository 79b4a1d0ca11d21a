"""The tables that a study of convergence leaves: its numbers with their errors, and its runs."""

import math
from collections.abc import Mapping

import pandas as pd

from taichi_silo.studies.converge.estimate import Number
from taichi_silo.studies.converge.ladder import Ladder
from taichi_silo.studies.converge.quantities import Quantity, words
from taichi_silo.studies.sweep.runs import Run

PARTS = ("grid", "length", "speed", "time")


def measure(name: str, number: Number) -> str:
    """What a relative error is over, in words."""
    if math.isnan(number.scale):
        return "over itself"
    return "over the weight of the sand" if number.unit == "N/m" else "over the largest stress of the profile"


def of_numbers(numbers: Mapping[str, Number]) -> pd.DataFrame:
    """One row a quantity: value, error, unit, error over its measure, and by part its error, order and trust."""
    rows = []
    for name, one in numbers.items():
        row = {"quantity": name, "in_words": words(name), "value": one.value, "error": one.error, "unit": one.unit,
               "relative_error": one.relative, "over": measure(name, one), "finest_run": one.computed}  # fmt: skip
        for part in PARTS:
            limit = one.parts.get(part)
            row |= {
                f"{part}_error": math.nan if limit is None else limit.error,
                f"{part}_order": None if limit is None else limit.order,
                f"{part}_trust": "none" if limit is None else limit.trust,
            }
        rows.append(row)
    return pd.DataFrame(rows)


def of_runs(
    ladder: Ladder, runs: Mapping[str, Run], found: Mapping[str, Mapping[str, Quantity]], steps: int
) -> pd.DataFrame:
    """One row a run: its step, cells, length, speed, cost, and all that it found."""
    rows = []
    for step in range(steps):
        for name, rung in ladder.step(step).items():
            run = runs[name]
            cost = run.summary.get("cost", {})
            rows.append({
                "run": name, "step": step + 1, "main": rung == ladder.main(step), "cell_size_m": rung.cell_m,
                "length_m": rung.length_m, "speed_m_per_s": rung.speed_m_per_s, "points": run.scene.points,
                "core_seconds": cost.get("seconds"), **{key: one.value for key, one in found[name].items()},
            })  # fmt: skip
    return pd.DataFrame(rows)
