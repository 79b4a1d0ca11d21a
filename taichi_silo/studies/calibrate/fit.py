"""Least squares over all tests at once, and how far the constants are known from it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from taichi_silo.studies.calibrate.closed_formulas import Guess, jaky
from taichi_silo.studies.calibrate.constants import HIGH, LOW, NAMES, SPAN, constants_of, interval, unknowns_of
from taichi_silo.studies.calibrate.lab_tests import Laboratory
from taichi_silo.studies.calibrate.paths import Law, oedometer, triaxial

# standard deviations at first of void ratio, of q over its largest value, of volume strain: then from what is left
NOISE = {"void ratio": 0.002, "deviator": 0.02, "volume strain": 0.001}
LEAST_NOISE = 0.05  # of those: what no laboratory is better than
SPECIMEN = 0.005  # standard deviation of the void ratio of a whole specimen
REPOSE_DEG, LIMIT = 1.0, 0.02  # of phi_c from the angle of repose; of e_d0 and e_c0 from e_min and e_max
HELD = 1.0  # standard deviation, over its range, with which a constant is held to its first value
STEP = 1e-4  # of the differences, over the range
ROUNDS = 3  # of fits, with the noise from the one before
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
    void_ratios: dict[str, float]  # of the specimens, by file
    evaluations: int


class Problem:
    """Residuals and their derivatives by unknowns: the eight of the constants, and a shift of each specimen's void ratio.

    One integration gives both: for the constants as they are, for each of them moved a little, and for the void ratio
    moved.
    """

    def __init__(self, lab: Laboratory, guess: dict[str, Guess]):
        self.lab = lab
        self.first = unknowns_of({name: one.value for name, one in guess.items()})
        self.noise = dict(NOISE)
        self.tests = len(lab.oedometers) + len(lab.triaxials)
        self.soft = self._soft()
        self.evaluations = 0
        self.kept: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def _soft(self) -> list[tuple[str, float, float]]:
        """What index tests say: constant, value, standard deviation."""
        index = self.lab.index
        tests = (
            ("critical_friction_angle_deg", index.friction_angle_deg, REPOSE_DEG), ("e_d0", index.e_min, LIMIT),
            ("e_c0", index.e_max, LIMIT),
        )  # fmt: skip
        return [(name, float(np.mean(values)), sd) for name, values, sd in tests if values]

    def curves(self, constants: dict[str, Any], shifts: np.ndarray) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Of every measured curve its kind, what was measured, and what the law gives (values x sets), over its size."""
        found = []
        law = Law(**{name: np.atleast_2d(value) for name, value in constants.items()})
        if tests := self.lab.oedometers:
            ends = np.log([[test.stress_Pa[0], test.stress_Pa.max()] for test in tests]).T
            e = np.array([[test.void_ratio[0]] for test in tests]) + shifts[: len(tests)]
            ratio = 1.0 - np.sin(np.radians(np.atleast_2d(constants["critical_friction_angle_deg"])))
            path = oedometer(law, ends, ratio, e)
            for k, test in enumerate(tests):
                _, given = path.at(k, np.log(test.stress_Pa[test.loading]))
                found.append(("void ratio", test.void_ratio[test.loading], given))
        if tests := self.lab.triaxials:
            ends = np.array([[min(0.0, test.strain[0]), test.strain.max()] for test in tests]).T
            e = np.array([[test.void_ratio] for test in tests]) + shifts[len(self.lab.oedometers) :]
            path = triaxial(law, ends, np.array([test.cell_Pa for test in tests]), e)
            for k, test in enumerate(tests):
                axial, given = path.at(k, test.strain[test.loading])
                q, volume = test.deviator_Pa[test.loading], test.volume_strain[test.loading]
                size, known = np.nanmax(q), np.isfinite(q)
                found.append(("deviator", q[known] / size, (axial[known] - test.cell_Pa) / size))
                if (known := np.isfinite(volume)).any():
                    found.append(("volume strain", volume[known], 1.0 - (1.0 + given[known]) / (1.0 + e[k])))
        return found

    def evaluated(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals over their noise, and their derivatives; rows of data first, then `held` rows."""
        if self.kept is not None and np.array_equal(self.kept[0], x):
            return self.kept[1:]
        self.evaluations += 1
        count = len(NAMES)
        steps = np.where(x[:count] + STEP * SPAN > HIGH, -STEP, STEP) * SPAN
        sets = np.repeat(x[:count, None], count + 2, axis=1)
        sets[np.arange(count), 1 + np.arange(count)] += steps
        shifts = np.repeat(x[count:, None], count + 2, axis=1)
        shifts[:, -1] += STEP
        constants = constants_of(sets)
        values, slopes = [], []
        for number, (kind, measured, given) in zip(self._owners(), self.curves(constants, shifts), strict=True):
            miss = np.clip(np.nan_to_num((given - measured[:, None]) / self.noise[kind], nan=1e4), -1e4, 1e4)
            slope = np.zeros((len(measured), count + self.tests))
            slope[:, :count] = (miss[:, 1:-1] - miss[:, :1]) / steps
            slope[:, count + number] = (miss[:, -1] - miss[:, 0]) / STEP
            values.append(miss[:, 0])
            slopes.append(slope)
        self.rows = [len(value) for value in values]
        for name, value, sd in self.soft:
            given = (np.asarray(constants[name]) - value) / sd
            values.append(given[:1])
            slopes.append(np.concatenate([(given[1:-1] - given[0]) / steps, np.zeros(self.tests)])[None])
        values.append(x[count:] / SPECIMEN)
        slopes.append(np.hstack([np.zeros((self.tests, count)), np.eye(self.tests) / SPECIMEN]))
        values.append((x[:count] - self.first) / (HELD * SPAN))
        slopes.append(np.hstack([np.diag(1.0 / (HELD * SPAN)), np.zeros((count, self.tests))]))
        self.kept = x.copy(), np.concatenate(values), np.concatenate(slopes)
        return self.kept[1:]

    def _owners(self) -> list[int]:
        """Which test each curve belongs to."""
        first = len(self.lab.oedometers)
        found = list(range(first))
        for number, test in enumerate(self.lab.triaxials, first):
            found += [number] * (1 + bool(np.isfinite(test.volume_strain[test.loading]).any()))
        return found

    def kinds(self) -> list[str]:
        """Kind of each curve."""
        found = ["void ratio"] * len(self.lab.oedometers)
        for test in self.lab.triaxials:
            found += ["deviator", *(["volume strain"] if np.isfinite(test.volume_strain[test.loading]).any() else [])]
        return found

    def residuals(self, x: np.ndarray) -> list[np.ndarray]:
        """Those of each curve, over its noise."""
        values, _ = self.evaluated(x)
        return np.split(values[: sum(self.rows)], np.cumsum(self.rows)[:-1])


def fitted(lab: Laboratory, guess: dict[str, Guess]) -> Fit:
    """The constants that are nearest to all tests, from a first guess."""
    problem = Problem(lab, guess)
    free = np.full(problem.tests, 10.0 * SPECIMEN)
    x = np.concatenate([problem.first, np.zeros(problem.tests)])
    bounds = np.concatenate([LOW, -free]), np.concatenate([HIGH, free])
    for _ in range(ROUNDS):
        problem.kept = None
        x = least_squares(
            lambda x: problem.evaluated(x)[0], x, lambda x: problem.evaluated(x)[1], bounds=bounds,
            x_scale=np.concatenate([SPAN, free]), xtol=1e-6, ftol=1e-7, max_nfev=60,
        ).x  # fmt: skip
        _estimate_noise(problem, x)
    return _judged(problem, x)


def _estimate_noise(problem: Problem, x: np.ndarray) -> None:
    """Standard deviation of what is left of each kind, less the degrees of freedom that the constants took."""
    left = problem.residuals(x)
    count = sum(map(len, left))
    lost = count / max(count - len(NAMES), 1.0)
    for kind in NOISE:
        mine = [one for one, name in zip(left, problem.kinds(), strict=True) if name == kind]
        if mine:
            size = float(np.sqrt(lost * np.mean(np.concatenate(mine) ** 2)))
            problem.noise[kind] = max(size * problem.noise[kind], LEAST_NOISE * NOISE[kind])
    problem.kept = None


def _judged(problem: Problem, x: np.ndarray) -> Fit:
    """How far the constants are known: from the tests alone, without what holds them to their first values."""
    _, slopes = problem.evaluated(x)
    count, data = len(NAMES), sum(problem.rows)
    weights = np.ones(len(slopes))
    weights[:data] = np.concatenate([np.full(len(one), 1.0 / _follows(one)) for one in problem.residuals(x)])
    scaled = (slopes * weights[:, None])[:-count] * np.concatenate([SPAN, np.ones(problem.tests)])
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
        noise={kind: problem.noise[kind] for kind in dict.fromkeys(problem.kinds())},
        void_ratios=dict(zip(problem.lab.names, _void_ratios(problem, x), strict=True)),
        evaluations=problem.evaluations,
    )


def _void_ratios(problem: Problem, x: np.ndarray) -> list[float]:
    firsts = [float(one.void_ratio[0]) for one in problem.lab.oedometers] + [
        t.void_ratio for t in problem.lab.triaxials
    ]
    return [first + float(shift) for first, shift in zip(firsts, x[len(NAMES) :], strict=True)]


def _follows(left: np.ndarray) -> float:
    """By how much a mean of residuals that follow each other is less certain than of independent ones.

    sqrt((1 + r) / (1 - r)) of their correlation r from one to the next, as of an autoregressive process.
    """
    if len(left) < 5 or not np.any(left):
        return 1.0
    r = float(np.sum(left[1:] * left[:-1]) / np.sum(left**2))
    r = min(max(r - 2.0 / np.sqrt(len(left)), 0.0), 0.98)  # what chance gives is left out
    return float(np.sqrt((1.0 + r) / (1.0 - r)))
