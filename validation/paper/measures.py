"""Numbers that a run's folder gives, by name: `MEASURES`. Each takes the run and words; nan where it is not defined."""

import numpy as np

from validation.paper import zones
from validation.paper.files import CaseRun, NotRun

__all__ = ["MEASURES", "READINGS", "CaseRun", "NotRun"]

EARLY, LATE, LAST = (0.0, 0.05), (0.70, 0.75), (0.95, 1.0)  # parts of flow; the last is the residual state
STILL_PA = 30.0  # of a mean stress: a smaller change is none
SMALLEST_PART_M = 0.02  # a transition has at least so much wall below and above it
SIDES = ("left", "right")


# forces


def force(run: CaseRun, name: str, state: str = "residual") -> float:
    """P, T, N [N/m] or angle [degrees]: "filling", "early", "least", "largest" or "residual"."""
    if state == "filling":
        return float(run.filled[name])
    if state in ("least", "largest"):
        return float(run.flow[name].min() if state == "least" else run.flow[name].max())
    return run.mean(name, *{"early": EARLY, "residual": LAST}[state])


def force_change(run: CaseRun, name: str, begin: str, end: str) -> float:
    """Change of a force between two states, over the weight of the fill [-]."""
    return (force(run, name, end) - force(run, name, begin)) / float(run.filled["weight_N_per_m"])


def force_drift(run: CaseRun, name: str) -> float:
    """How much a force still changes between 3/4 of the displacement and its end, over its residual value [-]."""
    last = force(run, name)
    return abs(last - run.mean(name, *LATE)) / max(abs(last), 1e-9)


# wall stresses


def largest_stress_kPa(
    run: CaseRun, stress: str = "normal", wall: str = "either", state: str = "flow", part: str = "all",
    reading: str = "node",
) -> float:  # fmt: skip
    """Largest stress [kPa] on a wall ("either": on both) in a state ("flow": maximum and residual).

    `part` is "all", "lower" (below half the height) or "upper".
    """
    most = -np.inf
    for side in SIDES if wall == "either" else (wall,):
        for one in ("maximum", "residual") if state == "flow" else (state,):
            height, value = run.profile(one, side, stress, reading)
            most = max(most, value[_part(run, part, height)].max(initial=-np.inf))
    return 1e-3 * float(most) if np.isfinite(most) else np.nan


def stress_ratio(
    run: CaseRun, stress: str = "normal", wall: str = "both", state: str = "residual", part: str = "all"
) -> float:
    """Mean stress of a part of a wall over that of the same heights after filling.

    `part` is "all", "lower", "upper", or "below" or "above" the transition (nan if there is none).
    """
    if part in ("below", "above"):
        level = 1e-3 * transition_mm(run, stress, wall, state)
        if not np.isfinite(level):
            return np.nan
    height, flow, filled = _against_filling(run, stress, wall, state)
    chosen = {"below": lambda: height < level, "above": lambda: height >= level}.get(
        part, lambda: _part(run, part, height)
    )()
    base = filled[chosen].mean() if chosen.any() else 0.0
    return float(flow[chosen].mean() / base) if base > 0.0 else np.nan


def transition_mm(run: CaseRun, stress: str = "normal", wall: str = "both", state: str = "residual") -> float:
    """Height [mm] below which the stress has fallen since filling, and above which it has risen; nan if there is none.

    It parts the profile (as pressure cells read it) so that the mean rise above less that below is largest.
    """
    height, flow, filled = _against_filling(run, stress, wall, state)
    rise, best, level = flow - filled, 0.0, np.nan
    for k in range(1, len(height)):
        if height[k] - height[0] < SMALLEST_PART_M or height[-1] - height[k] < SMALLEST_PART_M:
            continue
        gain = rise[k:].sum() - rise[:k].sum()
        if rise[:k].mean() < -STILL_PA and rise[k:].mean() > STILL_PA and gain > best:
            best, level = gain, 0.5 * (height[k - 1] + height[k])
    return 1e3 * float(level)


def profile_change(run: CaseRun, stress: str = "normal", wall: str = "both", state: str = "maximum") -> float:
    """Mean of |stress - stress after filling| over the mean stress after filling, as pressure cells read it [-]."""
    _, flow, filled = _against_filling(run, stress, wall, state)
    return float(np.abs(flow - filled).mean() / filled.mean())


def oscillation(run: CaseRun, stress: str = "normal", wall: str = "either", state: str = "maximum") -> float:
    """Root mean square of a stress about a cubic through it, over its mean, node by node [-]; the larger wall."""
    if wall == "either":
        return max(oscillation(run, stress, side, state) for side in SIDES)
    height, value = run.profile(state, wall, stress)
    place = (height - height.mean()) / np.ptp(height)
    rest = value - np.polyval(np.polyfit(place, value, 3), place)
    return float(np.sqrt(np.mean(rest**2)) / max(abs(value.mean()), 1.0))


def linearity(run: CaseRun, stress: str = "normal", wall: str = "both", state: str = "maximum") -> float:
    """Share of the variance of a stress that a straight line over the height explains [-]."""
    return float(np.corrcoef(*run.profile(state, wall, stress))[0, 1] ** 2)


def _against_filling(run, stress, wall, state):
    height, flow = run.profile(state, wall, stress, "cell")
    before, filled = run.profile("filling", wall, stress, "cell")
    common = (height >= before[0]) & (height <= before[-1])
    if common.sum() < 4:
        raise run.damaged("walls.csv has no heights in common")
    return height[common], flow[common], np.interp(height[common], before, filled)


def _part(run, part, height):
    middle = 0.5 * run.case.silo_height_m
    return {"all": np.isfinite(height), "lower": height < middle, "upper": height >= middle}[part]


# the run itself


def finished(run: CaseRun) -> float:
    """1 if it came to its end."""
    return float(run.summary.get("finished", False))


def inertial_number(run: CaseRun) -> float:
    """Inertial number, 99th percentile over the points in flow [-]; nan if the summary has none."""
    found = run.summary.get("certificate", {}).get("inertial_number_99th_percentile")
    return np.nan if found is None else float(found)


_OWN = (
    force, force_change, force_drift, largest_stress_kPa, stress_ratio, transition_mm, profile_change, oscillation,
    linearity, finished, inertial_number,
)  # fmt: skip
_OF_POINTS = (
    zones.wall_zone_mm, zones.wall_change, zones.mean_change, zones.interior_zones, zones.interior_zone_mm,
    zones.sheared_change, zones.sheared_height_mm, zones.outlet_change, zones.dead_share, zones.core_scatter,
)  # fmt: skip
MEASURES = {measure.__name__: measure for measure in (*_OWN, *_OF_POINTS)}
READINGS = {"largest_stress_kPa": ("node", "cell")}  # measures that are read both ways; only both make a "yes"
