"""The chart as a table: what each run costs, how far it is from the truth of its scene, and the Pareto front.

Errors of forces are over the weight of the sand, of the wall stress over the largest of its profile, of the thickness
of the zone over itself, as `taichi_silo.studies.converge.quantities` has it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from taichi_silo.studies.converge.quantities import Quantity

FORCES = ("P_residual", "T_residual", "N_residual")
MEASURES = {
    "P_filled": "P filled", "T_filled": "T filled", "N_filled": "N filled", "P_residual": "P", "T_residual": "T",
    "N_residual": "N", "pressure_residual_0.5": "wall stress", "zone_thickness": "zone",
}  # fmt: skip
WORST = "forces"  # the largest error of P, T and N at the end


@dataclass(frozen=True)
class Truth:
    """A quantity of a scene: value, half the width of the band that holds it, unit, and what errors are told over."""

    value: float
    error: float
    unit: str
    scale: float  # nan for the value itself

    @property
    def measure(self) -> float:
        """What errors are told over."""
        return abs(self.value if math.isnan(self.scale) else self.scale)

    @property
    def relative_error(self) -> float:
        """The error bar over its measure."""
        return self.error / self.measure


def errors(found: Mapping[str, Quantity], truth: Mapping[str, Truth]) -> dict[str, float]:
    """Of a run against the numbers of its scene, by the name of the measure; nan where there is nothing to compare."""
    result = {measure: _error(found.get(name), truth.get(name)) for name, measure in MEASURES.items()}
    return {WORST: max(result[MEASURES[name]] for name in FORCES)} | result


def _error(one: Quantity | None, truth: Truth | None) -> float:
    if one is None or truth is None:
        return math.nan
    return abs(one.value - truth.value) / truth.measure


def bars(truth: Mapping[str, Truth]) -> dict[str, float]:
    """Error bars of the truth itself, over the same measures."""
    result = {measure: truth[name].relative_error if name in truth else math.nan for name, measure in MEASURES.items()}
    return {WORST: max(result[MEASURES[name]] for name in FORCES)} | result


def front(cost: ArrayLike, error: ArrayLike) -> NDArray:
    """Which runs are on the Pareto front: no other is as good in cost and error and better in one.

    Parameters
    ----------
    cost, error : (n,) of each run; one with a nan is never on the front.

    Returns
    -------
    (n,) booleans.

    """
    cost, error = np.asarray(cost, float), np.asarray(error, float)
    sound = np.isfinite(cost) & np.isfinite(error)
    chosen = np.zeros(len(cost), bool)
    best = np.inf
    for k in np.lexsort((error, cost)):  # by cost, equal costs by error
        if sound[k] and (error[k] < best or (chosen & (cost == cost[k]) & (error == error[k])).any()):
            chosen[k], best = True, error[k]
    return chosen


def with_front(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with `on_front`, of the largest error of the forces at the end, in each scene."""
    best = pd.Series(False, index=rows.index)
    for _, some in rows.groupby("scene"):
        once = some.drop_duplicates("run")
        runs = once["run"][front(once["core_seconds"], once[WORST])]
        best |= (rows["scene"] == some["scene"].iloc[0]) & rows["run"].isin(runs)
    return rows.assign(on_front=best)
