"""How far the tests determine the constants, from the derivatives at the end of a fit."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from taichi_silo.studies.calibrate.closed_formulas import Guess
from taichi_silo.studies.calibrate.constants import NAMES, SPAN, width
from taichi_silo.studies.calibrate.problem import Problem

LEVEL = 0.95
LEAST = 1e-3  # singular value of what the tests do not see at all: an interval of a thousand ranges


@dataclass(frozen=True)
class Known:
    """What the tests tell of the constants, on the scale of their ranges.

    Attributes
    ----------
    slopes : derivatives of all residuals of tests by the constants, where the shifts of specimens follow: rows x 8.
    factor : standard deviations from the middle to the end of an interval of 95 %.
    covariance : of the constants, 8 x 8.

    """

    slopes: np.ndarray
    factor: float
    covariance: np.ndarray

    @classmethod
    def of(cls, slopes: np.ndarray, beside: np.ndarray, factor: float) -> "Known":
        """From derivatives by the constants (rows x 8), and by what is fitted beside them (rows x others)."""
        if beside.size:
            basis, _ = np.linalg.qr(beside)
            slopes = slopes - basis @ (basis.T @ slopes)
        return cls(slopes, factor, _covariance(slopes))

    @property
    def rank(self) -> int:
        """Directions of the constants whose interval is narrower than the range."""
        return int((np.linalg.svd(self.slopes, compute_uv=False) > 2.0 * self.factor).sum())

    def in_units(self) -> np.ndarray:
        """The covariance of the unknowns."""
        return self.covariance * np.outer(SPAN, SPAN)

    def widths(self, x: np.ndarray) -> dict[str, float]:
        """Widths of the intervals over the ranges, at these unknowns."""
        return {name: width(name, x[: len(NAMES)], self.in_units(), self.factor) for name in NAMES}

    def to_keep(self, x: np.ndarray, guess: dict[str, Guess]) -> list[str]:
        """The fewest constants that must keep their first values, for the tests to determine the others.

        One after the other, those that no test gave a first value first; of these e_c0, on which e_d0 and e_i0 rest,
        then the least known one.
        """
        wide = [name for name, one in self.widths(x).items() if one > 1.0]
        kept: list[str] = []
        while rest := [k for k, name in enumerate(NAMES) if name not in kept]:
            deviations = np.sqrt(np.diag(_covariance(self.slopes[:, rest])))
            open_ = [
                (guess[NAMES[k]].typical, NAMES[k] == "e_c0", sd, NAMES[k])
                for k, sd in zip(rest, deviations, strict=True) if NAMES[k] in wide and 2.0 * self.factor * sd > 1.0
            ]  # fmt: skip
            if not open_:
                break
            kept.append(max(open_)[-1])
        return kept


def knowledge(problem: Problem, x: np.ndarray) -> Known:
    """What the tests alone tell, without what holds constants to their first values."""
    _, slopes = problem.evaluated(x)
    count, data = len(NAMES), sum(problem.rows)
    weights = np.ones(data + problem.knowledge)
    weights[:data] = np.concatenate([np.full(len(one), 1.0 / _follows(one)) for one in problem.residuals(x)])
    scaled = slopes[: len(weights)] * weights[:, None]
    free = max(data - fitted_directions(problem, x), 1.0)
    factor = float(student.ppf(0.5 + 0.5 * LEVEL, free))
    return Known.of(scaled[:, :count] * SPAN, scaled[:, count:], factor)


def fitted_directions(problem: Problem, x: np.ndarray) -> float:
    """Degrees of freedom that a fit takes from the curves: the trace of what maps measured to fitted values.

    All unknowns, fewer where index tests and first values hold them.
    """
    _, slopes = problem.evaluated(x)
    scale = np.concatenate([SPAN, np.ones(len(problem.spread))])
    basis, _ = np.linalg.qr(slopes * scale)
    return float(np.sum(basis[: sum(problem.rows)] ** 2))


def _covariance(slopes: np.ndarray) -> np.ndarray:
    """Of what has these derivatives of residuals over their noise; large, not infinite, where they vanish."""
    _, sizes, directions = np.linalg.svd(slopes, full_matrices=False)
    found = (directions.T / (sizes**2 + LEAST**2)) @ directions
    missing = slopes.shape[1] - len(sizes)
    if missing > 0:  # fewer rows than constants
        found = found + (np.eye(slopes.shape[1]) - directions.T @ directions) / LEAST**2
    return found


def _follows(left: np.ndarray) -> float:
    """By how much a mean of residuals that follow each other is less certain than of independent ones.

    sqrt((1 + r) / (1 - r)) of their correlation r from one to the next, as of an autoregressive process.
    """
    if len(left) < 5 or not np.any(left):
        return 1.0
    r = float(np.sum(left[1:] * left[:-1]) / np.sum(left**2))
    r = min(max(r - 2.0 / np.sqrt(len(left)), 0.0), 0.98)  # what chance gives is left out
    return float(np.sqrt((1.0 + r) / (1.0 - r)))
