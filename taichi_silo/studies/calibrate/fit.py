"""Least squares over all tests at once, and how far the constants are known from it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from taichi_silo.studies.calibrate.closed_formulas import Guess
from taichi_silo.studies.calibrate.constants import HIGH, LOW, NAMES, SPAN, constants_of, interval
from taichi_silo.studies.calibrate.knowledge import fitted_directions, knowledge
from taichi_silo.studies.calibrate.lab_tests import Laboratory
from taichi_silo.studies.calibrate.problem import FREE, NOISE, Problem

LEAST_NOISE = 0.05  # of the noise at first: what no laboratory is better than
ROUNDS = 2  # of fits after the first, with the noise from the one before
ROUGH, EXACT = (1e-3, 15), (1e-6, 40)  # change of the sum of squares at which a search ends, and most evaluations
MOST_STEPS = 60_000  # of integration in all searches: half a minute of one core; six tests take 5000 to 11,000
LARGER = 1.25
ENTANGLED = 0.95  # correlation of a pair of constants that trade off
Heard = Callable[[str], None]


@dataclass(frozen=True)
class Fit:
    """Constants that are nearest to all tests."""

    constants: dict[str, float]
    intervals: dict[str, tuple[float, float]]  # with 95 %
    widths: dict[str, float]  # of the intervals, over the ranges of the constants
    kept: list[str]  # constants that keep their first value (e_d0 and e_i0 their share of e_c0)
    at_bound: list[str]
    rank: int  # directions of the eight constants that the tests determine
    entangled: list[tuple[str, str, float]]  # pairs that trade off, with their correlation
    noise: dict[str, float]  # standard deviation of what is left, by kind
    void_ratios: dict[str, float]  # of the specimens at the begin, by file
    offsets: dict[str, float]  # of measured void ratios in oedometer tests, by file
    evaluations: int
    settled: bool  # whether all searches came to their end

    @property
    def undetermined(self) -> list[str]:
        """Constants whose interval is wider than their range, and those that keep their first value."""
        return [name for name, one in self.widths.items() if one > 1.0 or name in self.kept]


class _Search:
    """Searches of the unknowns that are nearest to all tests, with so many steps of integration in all."""

    def __init__(self, problem: Problem, heard: Heard | None):
        self.problem, self.heard = problem, heard
        self.number, self.settled = 0, True
        free = np.full(len(problem.spread), FREE)
        self.low, self.high = np.concatenate([LOW, -free]), np.concatenate([HIGH, free])
        self.scale = np.concatenate([SPAN, free])

    def nearest(
        self, start: np.ndarray, exact: float, most: int, kept: tuple[str, ...] = ()
    ) -> tuple[float, np.ndarray]:
        """Half the sum of squares, and the unknowns where it is least; kept ones are as at the start."""
        self.number += 1
        moving = np.array([name not in kept for name in NAMES] + [True] * len(self.problem.spread))
        best: list[tuple[float, np.ndarray]] = []

        def whole(y: np.ndarray) -> np.ndarray:
            x = start.copy()
            x[moving] = y
            return x

        def residuals(y: np.ndarray) -> np.ndarray:
            if best and self.problem.steps > MOST_STEPS:
                raise _OutOfSteps
            x = whole(y)
            values, _ = self.problem.evaluated(x)
            best.append((0.5 * float(values @ values), x))
            best[:] = [min(best, key=lambda one: one[0])]
            if self.heard:
                self.heard(self._words(values))
            return values

        try:
            least_squares(
                residuals, start[moving], lambda y: self.problem.evaluated(whole(y))[1][:, moving],
                bounds=(self.low[moving], self.high[moving]), x_scale=self.scale[moving], xtol=1e-6, ftol=exact,
                max_nfev=most,
            )  # fmt: skip
        except _OutOfSteps:
            self.settled = False
        return best[0]

    def _words(self, values: np.ndarray) -> str:
        miss = float(np.sqrt(np.mean(values[: sum(self.problem.rows)] ** 2)))
        return f"search {self.number}, evaluation {self.problem.evaluations}: misses are {miss:.3g} of their noise"


class _OutOfSteps(Exception):
    """The searches have taken all steps that they may."""


def fitted(lab: Laboratory, guess: dict[str, Guess], heard: Heard | None = None) -> Fit:
    """The constants that are nearest to all tests, from a first guess.

    Those that the tests leave open keep their first values. `heard` is told after each evaluation how far it is.
    """
    problem = Problem(lab, guess)
    search = _Search(problem, heard)
    none = np.zeros(len(problem.spread))
    starts = [np.concatenate([start, none]) for start in _starts(problem.first)]
    _, x = min((search.nearest(start, *ROUGH) for start in starts), key=lambda found: found[0])
    for _ in range(ROUNDS):
        _estimate_noise(problem, x)
        _, x = search.nearest(x, *EXACT)
    _estimate_noise(problem, x)
    kept = tuple(knowledge(problem, x).to_keep(x, guess))
    if kept:
        places = [NAMES.index(name) for name in kept]
        x = x.copy()
        x[places] = problem.first[places]
        starts = [x, np.concatenate([problem.first, none])]
        _, x = min((search.nearest(start, *EXACT, kept) for start in starts), key=lambda found: found[0])
        _estimate_noise(problem, x)
    return _judged(problem, x, kept, search.settled)


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
    lost = count / max(count - fitted_directions(problem, x), 1.0)
    for kind in NOISE:
        mine = [one for one, name in zip(left, problem.kinds, strict=True) if name == kind]
        if mine:
            size = float(np.sqrt(lost * np.mean(np.concatenate(mine) ** 2)))
            problem.noise[kind] = max(size * problem.noise[kind], LEAST_NOISE * NOISE[kind])
    problem.kept = None


def _judged(problem: Problem, x: np.ndarray, kept: tuple[str, ...], settled: bool) -> Fit:
    known = knowledge(problem, x)
    count, in_units = len(NAMES), known.in_units()
    deviations = np.sqrt(np.diag(known.covariance))
    correlation = known.covariance / np.outer(deviations, deviations)
    entangled = [
        (NAMES[i], NAMES[j], float(correlation[i, j]))
        for i in range(count) for j in range(i)
        if abs(correlation[i, j]) > ENTANGLED and not {NAMES[i], NAMES[j]} <= set(kept)
    ]  # fmt: skip
    edge = 1e-3 * SPAN
    ends = [NAMES[k] for k in range(count) if not LOW[k] + edge[k] < x[k] < HIGH[k] - edge[k]]
    return Fit(
        constants={name: float(value) for name, value in constants_of(x[:count]).items()},
        intervals={name: interval(name, x[:count], in_units, known.factor) for name in NAMES},
        widths=known.widths(x), kept=list(kept), at_bound=[name for name in ends if name not in kept], rank=known.rank,
        entangled=entangled,
        noise={kind: problem.noise[kind] for kind in dict.fromkeys(problem.kinds)},
        void_ratios=dict(zip(problem.lab.names, _void_ratios(problem, x), strict=True)),
        offsets={
            test.name: float(shift)
            for test, shift in zip(problem.lab.oedometers, x[count + problem.tests :], strict=True)
        },
        evaluations=problem.evaluations, settled=settled,
    )  # fmt: skip


def _void_ratios(problem: Problem, x: np.ndarray) -> list[float]:
    firsts = [float(one.void_ratio[0]) for one in problem.lab.oedometers] + [
        t.void_ratio for t in problem.lab.triaxials
    ]
    return [first + float(shift) for first, shift in zip(firsts, x[len(NAMES) :], strict=False)]
