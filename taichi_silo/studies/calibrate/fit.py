"""Least squares over all tests at once, and how far the constants are known from it."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import t as student

from taichi_silo.studies.calibrate.closed_formulas import Guess
from taichi_silo.studies.calibrate.constants import HIGH, LOW, NAMES, SPAN, constants_of, interval
from taichi_silo.studies.calibrate.lab_tests import Laboratory
from taichi_silo.studies.calibrate.problem import FREE, NOISE, Problem

LEAST_NOISE = 0.05  # of the noise at first: what no laboratory is better than
ROUNDS = 2  # of fits after the first, with the noise from the one before
ROUGH, EXACT = (1e-3, 15), (1e-7, 60)  # change of the sum of squares at which a search ends, and most evaluations
LARGER = 1.25
ENTANGLED = 0.95  # correlation of a pair of constants that trade off
LEVEL = 0.95


@dataclass(frozen=True)
class Fit:
    """Constants that are nearest to all tests."""

    constants: dict[str, float]
    intervals: dict[str, tuple[float, float]]  # with 95 %
    undetermined: list[str]  # constants whose interval is wider than their range
    at_bound: list[str]
    rank: int  # directions of the eight constants that the tests determine
    entangled: list[tuple[str, str, float]]  # pairs that trade off, with their correlation
    noise: dict[str, float]  # standard deviation of what is left, by kind
    void_ratios: dict[str, float]  # of the specimens at the begin, by file
    offsets: dict[str, float]  # of measured void ratios in oedometer tests, by file
    evaluations: int


def fitted(lab: Laboratory, guess: dict[str, Guess]) -> Fit:
    """The constants that are nearest to all tests, from a first guess."""
    problem = Problem(lab, guess)
    free = np.full(len(problem.spread), FREE)
    bounds = np.concatenate([LOW, -free]), np.concatenate([HIGH, free])

    def nearest(x: np.ndarray, exact: float, most: int) -> OptimizeResult:
        return least_squares(
            lambda x: problem.evaluated(x)[0], x, lambda x: problem.evaluated(x)[1], bounds=bounds,
            x_scale=np.concatenate([SPAN, free]), xtol=1e-6, ftol=exact, max_nfev=most,
        )  # fmt: skip

    starts = [np.concatenate([start, np.zeros(len(free))]) for start in _starts(problem.first)]
    x = min((nearest(start, *ROUGH) for start in starts), key=lambda found: found.cost).x
    for _ in range(ROUNDS):
        _estimate_noise(problem, x)
        x = nearest(x, *EXACT).x
    _estimate_noise(problem, x)
    return _judged(problem, x)


def _starts(first: np.ndarray) -> list[np.ndarray]:
    """Where the search begins: at the first values, and with a larger e_i0 and a smaller h_s.

    Above e_i the law is as at e_i, so that a search that comes there from below may stay there.
    """
    other = first.copy()
    other[NAMES.index("e_i0")] *= LARGER
    other[NAMES.index("granular_hardness_Pa")] -= 1.0
    edge = 1e-6 * SPAN
    return [first, np.clip(other, LOW + edge, HIGH - edge)]


def _estimate_noise(problem: Problem, x: np.ndarray) -> None:
    """Standard deviation of what is left of each kind, less the degrees of freedom that the constants took."""
    left = problem.residuals(x)
    count = sum(map(len, left))
    lost = count / max(count - len(NAMES), 1.0)
    for kind in NOISE:
        mine = [one for one, name in zip(left, problem.kinds, strict=True) if name == kind]
        if mine:
            size = float(np.sqrt(lost * np.mean(np.concatenate(mine) ** 2)))
            problem.noise[kind] = max(size * problem.noise[kind], LEAST_NOISE * NOISE[kind])
    problem.kept = None


def _judged(problem: Problem, x: np.ndarray) -> Fit:
    """How far the constants are known: from the tests alone, without what holds them to their first values."""
    _, slopes = problem.evaluated(x)
    count, data = len(NAMES), sum(problem.rows)
    weights = np.ones(data + problem.knowledge)
    weights[:data] = np.concatenate([np.full(len(one), 1.0 / _follows(one)) for one in problem.residuals(x)])
    scaled = slopes[: len(weights)] * weights[:, None] * np.concatenate([SPAN, np.ones(len(problem.spread))])
    information = scaled.T @ scaled
    covariance = np.linalg.inv(information + 1e-6 * np.eye(len(information)))[:count, :count]
    factor = float(student.ppf(0.5 + 0.5 * LEVEL, max(data - count, 1)))
    deviations = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviations, deviations)
    entangled = [
        (NAMES[i], NAMES[j], float(correlation[i, j]))
        for i in range(count) for j in range(i)
        if abs(correlation[i, j]) > ENTANGLED
    ]  # fmt: skip
    in_units = covariance * np.outer(SPAN, SPAN)
    edge = 1e-3 * SPAN
    return Fit(
        constants={name: float(value) for name, value in constants_of(x[:count]).items()},
        intervals={name: interval(name, x[:count], in_units, factor) for name in NAMES},
        undetermined=[name for name, sd in zip(NAMES, deviations, strict=True) if 2.0 * factor * sd > 1.0],
        at_bound=[NAMES[k] for k in range(count) if not LOW[k] + edge[k] < x[k] < HIGH[k] - edge[k]],
        rank=int((2.0 * factor * np.sqrt(np.linalg.eigvalsh(covariance)) < 1.0).sum()),
        entangled=entangled,
        noise={kind: problem.noise[kind] for kind in dict.fromkeys(problem.kinds)},
        void_ratios=dict(zip(problem.lab.names, _void_ratios(problem, x), strict=True)),
        offsets={
            test.name: float(shift)
            for test, shift in zip(problem.lab.oedometers, x[count + problem.tests :], strict=True)
        },
        evaluations=problem.evaluations,
    )


def _void_ratios(problem: Problem, x: np.ndarray) -> list[float]:
    firsts = [float(one.void_ratio[0]) for one in problem.lab.oedometers] + [
        t.void_ratio for t in problem.lab.triaxials
    ]
    return [first + float(shift) for first, shift in zip(firsts, x[len(NAMES) :], strict=False)]


def _follows(left: np.ndarray) -> float:
    """By how much a mean of residuals that follow each other is less certain than of independent ones.

    sqrt((1 + r) / (1 - r)) of their correlation r from one to the next, as of an autoregressive process.
    """
    if len(left) < 5 or not np.any(left):
        return 1.0
    r = float(np.sum(left[1:] * left[:-1]) / np.sum(left**2))
    r = min(max(r - 2.0 / np.sqrt(len(left)), 0.0), 0.98)  # what chance gives is left out
    return float(np.sqrt((1.0 + r) / (1.0 - r)))
