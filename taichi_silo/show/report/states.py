"""What a run says of its three states: after filling, at the extremes of flow, and at the end."""

from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.measure.wall_pressure import CELL_M, CORNER_M, cell_mean
from taichi_silo.show.figures.forces import force
from taichi_silo.show.figures.run_files import GRAVITY, RunFiles
from taichi_silo.show.figures.wall_stress import HOPPER_CELL_M

FORCES = {  # key of summary.json, which extreme is the peak
    "P": ("bottom_N_per_m", "min"),
    "T": ("shear_N_per_m", "max"),
    "N": ("normal_N_per_m", "max"),
    "angle": ("wall_friction_angle_deg", "max"),
}
STATES = {"filling": "after filling", "maximum": "in flow, N largest", "residual": "at the end of flow"}
LAST_ROWS = 10  # whose median stands for the end of a run that left no summary
LEAST_SHARE = 0.01  # of the weight: a smaller N makes no angle in free outflow
SAME = 1e-4  # relative: walls.csv has six digits
NOTHING = 1e-4  # of the weight: a smaller force is none
BEGIN, END = 0.1, 0.5  # of the sand: between them the rate of a free outflow is taken


@dataclass(frozen=True)
class Force:
    """One force [N/m], or the angle arctan(T/N) [degrees], in the three states; None where the run does not tell.

    Attributes
    ----------
    filled : after filling.
    peak, peak_m : its least (P) or largest value in flow, and the displacement there [m].
    residual : mean of the last part of the flow; of a run without a summary the median of its last rows.

    """

    filled: float | None = None
    peak: float | None = None
    peak_m: float | None = None
    residual: float | None = None


@dataclass(frozen=True)
class Largest:
    """The largest normal stress on the vertical walls, away from the corner, as a pressure cell reads it [Pa].

    `displacement_m` is that of the flow where it was found in the course of it, else None.
    """

    stress_Pa: float
    wall: str
    height_m: float
    state: str
    node_Pa: float
    displacement_m: float | None = None


def forces_of(run: RunFiles) -> dict[str, Force]:
    """P, T, N and the wall friction angle."""
    summary = run.summary
    if not summary.get("filling") and not summary.get("residual"):
        return _from_rows(run)
    filling, peaks, residual = (summary.get(key) or {} for key in ("filling", "peak", "residual"))
    least = NOTHING * (summary.get("weight_N_per_m") or 0.0)
    found = {}
    for name, (key, extreme) in FORCES.items():
        peak = peaks.get(f"{extreme}_{key}") or {}
        values = (filling.get(key), peak.get("value"), residual.get(key))
        filled, extreme, last = (0.0 if value is not None and abs(value) < least else value for value in values)
        found[name] = Force(filled, extreme, peak.get("displacement_m"), last)
    return found | {"angle": _angle(run, found)} if run.free else found


def _angle(run: RunFiles, found: dict[str, Force]) -> Force:
    """Of free outflow: walls that the sand has left carry nothing, and arctan(T/N) says nothing there."""
    least = LEAST_SHARE * (run.summary.get("weight_N_per_m") or 0.0)
    touched = (found["N"].residual or 0.0) > least
    return Force(filled=found["angle"].filled, residual=found["angle"].residual if touched else None)


def _from_rows(run: RunFiles) -> dict[str, Force]:
    """Of a run that left no summary."""
    last = run.flow.tail(LAST_ROWS).median(numeric_only=True) if len(run.flow) else None
    return {name: Force(filled=_value(run.filled, name), residual=_value(last, name)) for name in FORCES}


def _value(row, name: str) -> float | None:
    if row is None:
        return None
    value = float(row["wall_friction_angle_deg"] if name == "angle" else 1e3 * force(row, name))
    return value if np.isfinite(value) else None


def largest_wall_stress(run: RunFiles, states=tuple(STATES)) -> Largest | None:
    """The largest of all vertical walls and the given states; None without wall profiles."""
    best = None
    for state in states:
        for wall in ("left", "right"):
            height, stress = profile(run, state, wall)
            if len(height) < 2:
                continue
            cell = cell_mean(height, stress)
            clear = (height > height[0] + CORNER_M + 0.5 * CELL_M) & np.isfinite(cell)
            if not clear.any():
                continue
            k = np.flatnonzero(clear)[np.argmax(cell[clear])]
            node = float(np.nanmax(stress[height > height[0] + CORNER_M], initial=0.0))
            if best is None or cell[k] > best.stress_Pa:
                best = Largest(float(cell[k]), wall, float(height[k]), state, node)
    return best


def largest_of_all(run: RunFiles) -> Largest | None:
    """The largest of the three states and of the whole flow, of which the run keeps its greatest moment."""
    known, found = largest_wall_stress(run), run.summary.get("largest_wall_normal_stress_in_flow")
    if not found or (known is not None and known.stress_Pa >= found["normal_stress_Pa"] * (1.0 - SAME)):
        return known
    place = (found["wall"], found["height_m"], "flow", found["node_Pa"], found["displacement_m"])
    return Largest(found["normal_stress_Pa"], *place)


def largest_hopper_stress(run: RunFiles, states=tuple(STATES)) -> Largest | None:
    """The same on the walls of a hopper, as a mean over 50 mm, which single rows of the grid ask for."""
    best = None
    for state in states:
        for wall in ("hopper_left", "hopper_right"):
            height, stress = profile(run, state, wall)
            if not len(height):
                continue
            mean = cell_mean(height, stress, HOPPER_CELL_M)
            k = int(np.argmax(mean))
            if best is None or mean[k] > best.stress_Pa:
                best = Largest(float(mean[k]), wall, float(height[k]), state, float(stress.max()))
    return best


def profile(run: RunFiles, state: str, wall: str, quantity: str = "normal_stress_Pa"):
    """Rising heights above the initial bottom [m] and nodal stresses [Pa] along one wall; empty if there are none."""
    rows = run.walls[(run.walls["state"] == state) & (run.walls["wall"] == wall)].sort_values("height_m")
    rows = rows.dropna(subset=["height_m", quantity])
    return rows["height_m"].to_numpy(float), rows[quantity].to_numpy(float)


def wall_profile(run: RunFiles, state: str, quantity: str = "normal_stress_Pa", wall: str = "both"):
    """The same as a pressure cell reads it; with "both" the mean of the two walls."""
    if wall != "both":
        height, stress = profile(run, state, wall, quantity)
        return height, cell_mean(height, stress)
    (height, left), right = (profile(run, state, side, quantity) for side in ("left", "right"))
    if not len(height) or not len(right[0]):
        return np.zeros(0), np.zeros(0)
    return height, cell_mean(height, 0.5 * (left + np.interp(height, *right)))


def discharge_rate_kg_per_s_m(run: RunFiles) -> float | None:
    """Mean rate at which sand left [kg/s per metre]: of free outflow while 10 to 50 % leave, else of the whole flow."""
    rows = run.flow
    if len(rows) < 2 or "discharged_kg_per_m" not in rows:
        return None
    gone, time = rows["discharged_kg_per_m"].to_numpy(float), rows["time_s"].to_numpy(float)
    first, last = 0, len(gone) - 1
    if run.free:
        gravity = run.parameter("method", "gravity_m_per_s2", GRAVITY)
        whole = gone[0] + rows["weight_N_per_m"].iloc[0] / gravity
        first, last = (int(np.searchsorted(gone, share * whole)) for share in (BEGIN, END))
        last = min(last, len(gone) - 1)
    if first >= last or not gone[last] > gone[first]:
        return None
    return float((gone[last] - gone[first]) / (time[last] - time[first]))
