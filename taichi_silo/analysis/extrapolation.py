"""What a quantity tends to as a numerical parameter goes to its aim, and how far that can be trusted.

A result f that is computed with a cell size (or a length, or a speed) x is taken as

    f(x) = F + a (x^p - x_t^p),        x_t the aim: 0 for cells, the sand's own for a length

with the order p that the results show (Richardson's extrapolation). The uncertainty goes after the grid convergence
index of ASME V&V 20 (2009) and the least-squares fit of L. Eca and M. Hoekstra, J. Comput. Phys. 262 (2014) 104-130;
of their fits with fixed orders and their weights it makes no use.

    three or more results:   F, a, p by least squares, s their standard deviation from the fit
      s below the mean step from result to result:   U = f_s |F - f_1| + s + |f_1 - fit_1|
      else they scatter:                             U = 3 times their range, and F = f_1
      f_s = 1.25 where four results show 0.5 <= p <= 2.1 (the asymptotic range), else 3; for F p is kept in 0.5 to 2
      of four results U is no less than the distance of F from what the first three and the last three alone tend to,
      and of all no less than what the last two would tell with p = 1
    two results:             p = 1 assumed, f_s = 3

f_1 belongs to the x nearest to its aim. U is meant to hold the truth in 95 of 100 cases; how often it does is measured
(`validation/error_bars.py`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

ORDERS = (0.5, 2.1)  # of the asymptotic range: the method's own order is 2, shear zones and walls make it less
FORMAL = 2.0  # order of the method
SURE, UNSURE = 1.25, 3.0  # factors of safety
FEWEST = 3  # results that show an order; more are needed to be sure of it
FIRST, LAST = slice(None, -1), slice(1, None)  # of the results
ROUND_OFF = 1e-12  # of a value: results that differ by less are the same


@dataclass(frozen=True)
class Limit:
    """What a series of results tends to."""

    value: float  # F
    error: float  # U, half the width of the band that holds the truth; nan if one result only is there
    order: float | None  # p as observed; None where the series cannot tell it
    trust: str  # "asymptotic", "outside the asymptotic range", "scattered", "order assumed", "exact", "one result"


def limit(sizes: Sequence[float], values: Sequence[float], aim: float = 0.0) -> Limit:
    """Extrapolate results to the aim of their parameter.

    Parameters
    ----------
    sizes : the parameter, falling towards its aim.
    values : the results.
    aim : of the parameter, at most the last size.

    """
    x, f = np.asarray(sizes, float), np.asarray(values, float)
    if len(x) != len(f) or len(x) == 0 or np.any(np.diff(x) >= 0.0) or not 0.0 <= aim <= x[-1]:
        raise ValueError(f"sizes are {list(sizes)}; they must fall to the aim {aim}, one for each value")
    last = float(f[-1])
    spread = float(np.ptp(f))
    if not np.all(np.isfinite(f)):
        return Limit(last, math.nan, None, "one result")
    if x[-1] <= aim * (1.0 + ROUND_OFF):
        return Limit(last, 0.0, None, "exact")
    if len(f) == 1:
        return Limit(last, math.nan, None, "one result")
    if spread <= ROUND_OFF * abs(last):
        return Limit(last, spread, None, "exact")
    if len(f) == 2:
        rest = _fit(x, f, 1.0, aim)[0] - last
        return Limit(last + rest, UNSURE * abs(rest), None, "order assumed")
    return _of_three(x, f, aim, spread)


def _of_three(x: np.ndarray, f: np.ndarray, aim: float, spread: float) -> Limit:
    """The limit of three or more results."""
    observed = _order(x, f, aim)
    p = min(max(observed, ORDERS[0]), FORMAL)
    value, fitted, deviation = _fit(x, f, p, aim)
    last = float(f[-1])
    if deviation >= spread / (len(f) - 1) or not _monotone(f):
        return Limit(last, UNSURE * spread, None, "scattered")
    asymptotic = ORDERS[0] <= observed <= ORDERS[1]
    factor = SURE if asymptotic and len(f) > FEWEST else UNSURE
    least = [abs(_fit(x[-2:], f[-2:], 1.0, aim)[0] - last)]
    if len(f) > FEWEST:
        least += [abs(limit(list(x[part]), list(f[part]), aim).value - value) for part in (FIRST, LAST)]
    error = max(factor * abs(value - last) + deviation + abs(last - fitted), *least)
    return Limit(value, error, observed, "asymptotic" if asymptotic else "outside the asymptotic range")


def _monotone(f: np.ndarray) -> bool:
    """Whether the last three results go one way."""
    steps = np.diff(f[-3:])
    return bool(np.all(steps > 0.0) or np.all(steps < 0.0))


def _order(x: np.ndarray, f: np.ndarray, aim: float) -> float:
    """The order whose fit deviates least."""
    found = minimize_scalar(lambda p: _fit(x, f, p, aim)[2], bounds=(0.05, 6.0), method="bounded")
    return float(found.x)


def _fit(x: np.ndarray, f: np.ndarray, p: float, aim: float) -> tuple[float, float, float]:
    """Value at the aim, fitted value of the last result, and standard deviation of all, at a given order."""
    rest = (x / x[0]) ** p - (aim / x[0]) ** p
    matrix = np.stack([np.ones_like(rest), rest], axis=1)
    (value, slope), *_ = np.linalg.lstsq(matrix, f, rcond=None)
    fitted = value + slope * rest
    free = max(len(f) - 3, 1)
    return float(value), float(fitted[-1]), float(math.sqrt(((f - fitted) ** 2).sum() / free))
