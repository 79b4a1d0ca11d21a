"""The Pareto front: what cannot be had more accurately without paying more."""

import numpy as np


def front(cost, error) -> np.ndarray:
    """Which points are on it: no other is as good in both and better in one.

    Parameters
    ----------
    cost, error : (n,) of each point; one with a nan is never on the front.

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
