"""What a run found, as single numbers that a study of convergence extrapolates, each with its unit and its measure.

An error is told over the measure (`scale`): forces over the weight of the sand, since P may go to zero; wall stresses
over the largest of their profile; all else over itself.
"""

import math
from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.measure.wall_pressure import cell_mean
from taichi_silo.runs.result import Result, residual
from taichi_silo.show.report.states import discharge_rate_kg_per_s_m
from taichi_silo.simulation.filling import SETTLED

FORCES = {"P": "bottom_N_per_m", "T": "shear_N_per_m", "N": "normal_N_per_m"}
STATES = {"filled": "filling", "residual": "residual"}
EXTREMES = {"P_least": "min_bottom_N_per_m", "T_largest": "max_shear_N_per_m", "N_largest": "max_normal_N_per_m"}
HEIGHTS = (0.1, 0.3, 0.5, 0.7, 0.9)  # over the height of the fill: where the wall's normal stress is taken
BAND = 0.1  # of the height, over which it is a mean
WALLS = ("left", "right")
WORDS = {
    "P": "force on the bottom", "T": "friction on a wall", "N": "normal force on a wall",
    "TN": "mobilised friction T/N", "filled": "after filling", "residual": "at the end", "least": "least in flow",
    "largest": "largest in flow", "pressure": "wall normal stress",
    "zone_thickness": "thickness of the wall's shear zone", "discharge_rate": "rate of discharge",
}  # fmt: skip
NAMES = (
    *(f"{force}_{state}" for state in STATES for force in (*FORCES, "TN")), *EXTREMES,
    *(f"pressure_{state}_{share:g}" for state in STATES for share in HEIGHTS), "zone_thickness", "discharge_rate",
)  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """One number of a run."""

    value: float
    unit: str
    scale: float  # what its error is told over; nan for the value itself
    unsteady: float = 0.0  # by how much it may still change with time


def quantities(run: Result) -> dict[str, Quantity]:
    """All numbers that a run has, by their names; what it lacks is left out."""
    summary, found = run.summary, {}
    weight = summary.get("weight_N_per_m", math.nan)
    for state, table in STATES.items():
        forces, moving = {name: summary.get(table, {}).get(key) for name, key in FORCES.items()}, _unsteady(run, state)
        for name, value in forces.items():
            found[f"{name}_{state}"] = Quantity(_number(value), "N/m", weight, moving[name])
        found[f"TN_{state}"] = Quantity(_ratio(forces["T"], forces["N"]), "-", math.nan)
    for name, key in EXTREMES.items():
        value = summary.get("peak", {}).get(key, {}).get("value")
        found[name] = Quantity(_number(value), "N/m", weight)
    for state in STATES:
        found |= _pressures(run, state)
    zones = [_number(summary.get("shear_zones", {}).get(wall, {}).get("thickness_m")) for wall in WALLS]
    if min(zones) > 0.0:
        found["zone_thickness"] = Quantity(float(np.mean(zones)), "m", math.nan)
    if run.scene.silo.has_opening:
        found["discharge_rate"] = Quantity(_number(discharge_rate_kg_per_s_m(run)), "kg/(s m)", math.nan)
    return {name: one for name, one in found.items() if math.isfinite(one.value)}


def words(name: str) -> str:
    """A quantity in words: "normal force on a wall, at the end"."""
    if name in WORDS:
        return WORDS[name]
    first, state, *rest = name.split("_")
    at = f" at {100 * float(rest[0]):g} % of the height" if rest else ""
    return f"{WORDS[first]}{at}, {WORDS[state]}"


def _unsteady(run: Result, state: str) -> dict[str, float]:
    """Of each force, how its mean over the span of the state differs from that over the span before [N/m].

    After filling a span is one period of the column, and it is at least what counts as rest; at the end a span is a
    half of the last 5 % of the displacement.
    """
    if state == "filled":
        rows, count = run.filling, run.scene.output.records_per_period
    else:
        rows = residual(run.flow)
        count = len(rows) // 2
    last, before = rows.tail(count), rows.iloc[-2 * count : -count]
    if not count or len(before) < count:
        return dict.fromkeys(FORCES, 0.0)
    least = SETTLED if state == "filled" else 0.0
    means = {name: float(last[name].mean()) for name in FORCES}
    return {name: max(abs(mean - float(before[name].mean())), least * abs(mean)) for name, mean in means.items()}


def _pressures(run: Result, state: str) -> dict[str, Quantity]:
    """Mean normal stress of both walls over bands of the height."""
    high, found = run.scene.silo.height_m, {}
    profiles = [run.profile({"filled": "filling"}.get(state, state), wall) for wall in WALLS]
    if not all(len(height) > 1 for height, _ in profiles):
        return {}
    for share in HEIGHTS:
        means = [float(np.interp(share * high, height, cell_mean(height, stress, BAND * high)))
                 for height, stress in profiles if height[0] <= share * high <= height[-1]]  # fmt: skip
        if means:
            found[f"pressure_{state}_{share:g}"] = float(np.mean(means))
    largest = max(found.values(), default=math.nan)
    least = SETTLED if state == "filled" else 0.0
    return {name: Quantity(value, "Pa", largest, least * value) for name, value in found.items()}


def _number(value) -> float:
    return math.nan if value is None else float(value)


def _ratio(one, other) -> float:
    return _number(one) / _number(other) if other else math.nan
