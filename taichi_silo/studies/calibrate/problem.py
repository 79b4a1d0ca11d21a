"""What least squares makes small: misses of all curves, of index tests, and of first values that nothing else holds."""

from typing import Any, NamedTuple

import numpy as np

from taichi_silo.studies.calibrate.closed_formulas import Guess
from taichi_silo.studies.calibrate.constants import HIGH, NAMES, SPAN, constants_of, unknowns_of
from taichi_silo.studies.calibrate.lab_tests import Laboratory, Oedometer, Triaxial
from taichi_silo.studies.calibrate.paths import Law, oedometer, triaxial

# standard deviations at first of void ratio, of q over its largest value, of volume strain: then from what is left
NOISE = {"void ratio": 0.002, "deviator": 0.02, "volume strain": 0.001}
SPECIMEN = 0.005  # standard deviation of the void ratio of a whole specimen
REPOSE_DEG, LIMIT = 1.0, 0.02  # of phi_c from the angle of repose; of e_d0 and e_c0 from e_min and e_max
HELD = 1.0  # standard deviation, over its range, with which a constant is held to its first value
FAR = 1e4  # what is no number counts as so many standard deviations
STEP = 1e-4  # of the differences, over the range


class MeasuredCurve(NamedTuple):
    """A curve of a test: the test's number, what was measured, and what the law gives (values x sets of constants)."""

    test: int
    kind: str  # of NOISE
    measured: np.ndarray
    given: np.ndarray


class Problem:
    """Residuals and their derivatives by unknowns: eight of the constants, and a shift of each specimen's void ratio.

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
        self.rows: list[int] = []  # of each curve
        self.kinds: list[str] = []
        self.kept: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def _soft(self) -> list[tuple[str, float, float]]:
        """What index tests say: constant, value, standard deviation."""
        index = self.lab.index
        tests = (
            ("critical_friction_angle_deg", index.friction_angle_deg, REPOSE_DEG), ("e_d0", index.e_min, LIMIT),
            ("e_c0", index.e_max, LIMIT),
        )  # fmt: skip
        return [(name, float(np.mean(values)), sd) for name, values, sd in tests if values]

    def curves(self, constants: dict[str, Any], shifts: np.ndarray) -> list[MeasuredCurve]:
        """Every measured curve, and what the law gives for each set of constants and of shifts of void ratios."""
        law = Law(**{name: np.atleast_2d(value) for name, value in constants.items()})
        first = len(self.lab.oedometers)
        found = _compressions(self.lab.oedometers, law, shifts[:first]) if first else []
        return found + (_shearings(self.lab.triaxials, law, shifts[first:], first) if self.lab.triaxials else [])

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
        curves = self.curves(constants, shifts)
        for curve in curves:
            miss = (curve.given - curve.measured[:, None]) / self.noise[curve.kind]
            miss = np.clip(np.nan_to_num(miss, nan=FAR), -FAR, FAR)
            slope = np.zeros((len(miss), count + self.tests))
            slope[:, :count] = (miss[:, 1:-1] - miss[:, :1]) / steps
            slope[:, count + curve.test] = (miss[:, -1] - miss[:, 0]) / STEP
            values.append(miss[:, 0])
            slopes.append(slope)
        self.rows, self.kinds = [len(value) for value in values], [curve.kind for curve in curves]
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

    def residuals(self, x: np.ndarray) -> list[np.ndarray]:
        """Those of each curve, over its noise."""
        values, _ = self.evaluated(x)
        return np.split(values[: sum(self.rows)], np.cumsum(self.rows)[:-1])


def _compressions(tests: list[Oedometer], law: Any, shifts: np.ndarray) -> list[MeasuredCurve]:
    """First loading of oedometer tests."""
    ends = np.log([[test.stress_Pa[0], test.stress_Pa.max()] for test in tests]).T
    e = np.array([[test.void_ratio[0]] for test in tests]) + shifts
    path = oedometer(law, ends, 1.0 - np.sin(np.radians(law.critical_friction_angle_deg)), e)
    found = []
    for number, test in enumerate(tests):
        _, given = path.at(number, np.log(test.stress_Pa[test.loading]))
        found.append(MeasuredCurve(number, "void ratio", test.void_ratio[test.loading], given))
    return found


def _shearings(tests: list[Triaxial], law: Any, shifts: np.ndarray, first: int) -> list[MeasuredCurve]:
    """First loading of triaxial tests, q over its largest value; the first of them has this number."""
    ends = np.array([[min(0.0, test.strain[0]), test.strain.max()] for test in tests]).T
    e = np.array([[test.void_ratio] for test in tests]) + shifts
    path = triaxial(law, ends, np.array([test.cell_Pa for test in tests]), e)
    found = []
    for k, test in enumerate(tests):
        axial, given = path.at(k, test.strain[test.loading])
        q, volume = test.deviator_Pa[test.loading], test.volume_strain[test.loading]
        size, known = np.nanmax(q), np.isfinite(q)
        found.append(MeasuredCurve(first + k, "deviator", q[known] / size, (axial[known] - test.cell_Pa) / size))
        if (known := np.isfinite(volume)).any():
            lost = 1.0 - (1.0 + given[known]) / (1.0 + e[k])
            found.append(MeasuredCurve(first + k, "volume strain", volume[known], lost))
    return found
