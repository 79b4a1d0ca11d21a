"""Errors of a run against the reference, the scatter below which they mean nothing, and the Pareto front."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

ERRORS = ("error_P", "error_T", "error_N", "error_profile", "error_zone")


def relative_difference(values: ArrayLike, reference: ArrayLike) -> float:
    """Norm of the difference over the norm of the reference (L2 over equally spaced places) [-].

    Raises
    ------
    ValueError
        if they do not belong to the same places.

    """
    values, reference = np.asarray(values, float), np.asarray(reference, float)
    if values.shape != reference.shape:
        raise ValueError(f"curves of {values.shape} and {reference.shape} places cannot be compared")
    return float(np.linalg.norm(values - reference) / np.linalg.norm(reference))


def errors(found: dict, reference: dict) -> dict[str, float]:
    """Errors of a run, as `parameter_set.simulate` returns it; nan where it failed, or there is nothing to compare.

    error_P, error_T, error_N
        `relative_difference` of the force over the bottom displacement, from 2 % of it (about one period of the column
        at the base speed) to its end, in a hundred parts.
    error_profile
        `relative_difference` of the wall normal stress over height, mean of both walls and of the last fifth of the
        displacement, smoothed over 20 mm, from 22.5 mm above the plate to 0.9 of the fill height.
    error_zone
        Relative difference of the mean thickness of the shear zones at the walls at the end; nan where the reference
        has none.

    """
    if found["failure"] is not None or reference["failure"] is not None:
        return dict.fromkeys(ERRORS, math.nan)
    result = {f"error_{name}": relative_difference(found["curves"][name], reference["curves"][name]) for name in "PTN"}
    stress = [run["profile"]["normal_stress_Pa"] for run in (found, reference)]
    result["error_profile"] = relative_difference(*stress)
    zone, right = found["zone_thickness_m"], reference["zone_thickness_m"]
    result["error_zone"] = abs(zone / right - 1.0) if right and zone is not None else math.nan
    return result


def scatter(runs: list[dict]) -> dict[str, float]:
    """Greatest error of one run against another that differs from it by rounding only; nan with fewer than two."""
    pairs = [errors(one, other) for i, one in enumerate(runs) for other in runs[i + 1 :]]
    found = {name: [pair[name] for pair in pairs if math.isfinite(pair[name])] for name in ERRORS}
    return {name: max(values, default=math.nan) for name, values in found.items()}


def pareto_front(cost: ArrayLike, error: ArrayLike) -> NDArray:
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
