"""What a run says of its three states: after filling, at the extremes of flow, and at the end."""

import itertools
from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.measure.wall_pressure import Reading, cell_mean
from taichi_silo.runs.result import Result

FORCES = {  # key of summary.json, which extreme is the peak
    "P": ("bottom_N_per_m", "min"),
    "T": ("shear_N_per_m", "max"),
    "N": ("normal_N_per_m", "max"),
    "angle": ("wall_friction_angle_deg", "max"),
}
STATES = {"filling": "after filling", "maximum": "in flow, N largest", "residual": "at the end of flow"}
LEAST_SHARE = 0.01  # of the weight: a smaller N makes no angle in free outflow
SAME = 1e-4  # relative: walls.csv has six digits
NOTHING = 1e-4  # of the weight: a smaller force is none
BEGIN, END = 0.1, 0.5  # of the sand: between them the rate of a free outflow is taken


@dataclass(frozen=True)
class Force:
    """One force [N/m], or the angle arctan(T/N) [degrees], in the three states; None where the run does not tell."""

    filled: float | None = None
    peak: float | None = None  # its least (P) or largest value in flow
    peak_m: float | None = None  # the displacement there
    residual: float | None = None  # mean of the last part of the flow


@dataclass(frozen=True)
class Largest:
    """The largest normal stress on some walls [Pa], as a pressure cell reads it, and at one node.

    `displacement_m` is that of the flow where it was found in the course of it, else None.
    """

    stress_Pa: float
    wall: str
    height_m: float
    state: str
    node_Pa: float
    displacement_m: float | None = None


def forces_of(run: Result) -> dict[str, Force]:
    """P, T, N and the wall friction angle, from the summary; of a run that left none from its records."""
    summary = run.summary
    if not summary.get("filling") and not summary.get("residual"):
        return {name: Force(_value(run.filled, name), residual=_value(run.residual, name)) for name in FORCES}
    filling, peaks, last = (summary.get(key) or {} for key in ("filling", "peak", "residual"))
    smallest = NOTHING * (summary.get("weight_N_per_m") or 0.0)
    found = {}
    for name, (key, extreme) in FORCES.items():
        least = 0.0 if name == "angle" else smallest
        peak = peaks.get(f"{extreme}_{key}") or {}
        values = (filling.get(key), peak.get("value"), last.get(key))
        filled, most, end = (0.0 if value is not None and abs(value) < least else value for value in values)
        found[name] = Force(filled, most, peak.get("displacement_m"), end)
    if run.free:  # walls that the sand has left carry nothing, and arctan(T/N) says nothing there
        touched = (found["N"].residual or 0.0) > LEAST_SHARE * (summary.get("weight_N_per_m") or 0.0)
        angle = found["angle"]
        found["angle"] = Force(filled=angle.filled, residual=angle.residual if touched else None)
    return found


def _value(row, name: str) -> float | None:
    value = np.nan if row is None else float(row["wall_friction_angle_deg" if name == "angle" else name])
    return value if np.isfinite(value) else None


def largest_wall_stress(run: Result, states: tuple[str, ...] = tuple(STATES)) -> Largest | None:
    """Largest normal stress on the vertical walls in the given states, away from the corner; None without profiles."""
    if not run.scene.silo.straight_m:
        return None
    reading = reading_of(run)
    return _largest(run, states, ("left", "right"), reading.cell_m, reading.corner_m)


def largest_hopper_stress(run: Result) -> Largest | None:
    """Largest normal stress on the walls of a hopper, as a mean that single rows of the grid ask for."""
    cell = reading_of(run).hopper_cell_m
    return _largest(run, tuple(STATES), ("hopper_left", "hopper_right"), cell, -cell)


def reading_of(run: Result) -> Reading:
    """Lengths over which the wall stresses of a run are read."""
    return Reading.of(run.scene.silo.width_m, run.scene.silo.height_m)


def _largest(run: Result, states: tuple[str, ...], walls: tuple[str, ...], cell_m: float, out_m: float):
    """Largest normal stress on some walls; cells that reach lower than `out_m` above the lowest node are left out."""
    found = []
    for state, wall in itertools.product(states, walls):
        height, stress = run.profile(state, wall)
        above = height - np.min(height, initial=np.inf)
        clear = np.flatnonzero(above > out_m + 0.5 * cell_m)
        if len(clear):
            mean = cell_mean(height, stress, cell_m)
            k = clear[np.argmax(mean[clear])]
            node = float(np.max(stress[above > out_m], initial=0.0))
            found.append(Largest(float(mean[k]), wall, float(height[k]), state, node))
    return max(found, key=lambda one: one.stress_Pa, default=None)


def largest_of_all(run: Result) -> Largest | None:
    """Largest wall stress of the three states and of the whole flow, of which the run keeps its greatest moment."""
    known, found = largest_wall_stress(run), run.summary.get("largest_wall_normal_stress_in_flow")
    if not found or (known is not None and known.stress_Pa >= found["normal_stress_Pa"] * (1.0 - SAME)):
        return known
    place = (found["wall"], found["height_m"], "flow", found["node_Pa"], found["displacement_m"])
    return Largest(found["normal_stress_Pa"], *place)


def wall_profile(
    run: Result, state: str, quantity: str = "normal_stress_Pa", wall: str = "both"
) -> tuple[np.ndarray, np.ndarray]:
    """Rising heights [m] and stresses [Pa] along a wall (or the mean of "both") as a pressure cell reads them."""
    cell = reading_of(run).cell_m
    if wall != "both":
        height, stress = run.profile(state, wall, quantity)
        return height, cell_mean(height, stress, cell)
    (height, left), right = (run.profile(state, side, quantity) for side in ("left", "right"))
    if not len(height) or not len(right[0]):
        return np.zeros(0), np.zeros(0)
    return height, cell_mean(height, 0.5 * (left + np.interp(height, *right)), cell)


def discharge_rate_kg_per_s_m(run: Result) -> float | None:
    """Mean rate at which sand left [kg/s per metre]: of free outflow while 10 to 50 % leave, else of the whole flow."""
    rows = run.flow
    if len(rows) < 2 or "discharged_kg_per_m" not in rows:
        return None
    gone, time = rows["discharged_kg_per_m"].to_numpy(float), rows["time_s"].to_numpy(float)
    first, last = 0, len(gone) - 1
    if run.free:
        whole = gone[0] + rows["weight_N_per_m"].iloc[0] / run.scene.method.gravity_m_per_s2
        first, last = (int(np.searchsorted(gone, share * whole)) for share in (BEGIN, END))
        last = min(last, len(gone) - 1)
    if first >= last or not gone[last] > gone[first]:
        return None
    return float((gone[last] - gone[first]) / (time[last] - time[first]))
