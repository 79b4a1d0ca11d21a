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
FREE = 0.05  # of that at the begin of an oedometer test, which its curve tells
REPOSE_DEG, LIMIT = 1.0, 0.02  # of phi_c from the angle of repose; of e_d0 and e_c0 from e_min and e_max
LOOSEST, LOOSENESS = 0.99, 0.001  # share of e_i that a specimen may have, and standard deviation of what exceeds it
HELD = 1.0  # standard deviation, over its range, with which a constant is held to its first value
FAR = 1e4  # what is no number counts as so many standard deviations
STEP = 1e-4  # of the differences, over the range


class MeasuredCurve(NamedTuple):
    """A curve of a test: the test's number, what was measured, and what the law gives (values x sets of constants)."""

    test: int
    kind: str  # of NOISE
    measured: np.ndarray
    given: np.ndarray
    looseness: np.ndarray  # largest void ratio over e_i on the path, of each set


class Problem:
    """Residuals and their derivatives by unknowns: eight of the constants, and a shift of each specimen's void ratio.

    In an oedometer test the whole measured curve may be off as well: a third kind of unknown. One integration gives
    residuals and derivatives: for the constants as they are, for each of them moved a little, and for the void ratio
    moved.
    """

    def __init__(self, lab: Laboratory, guess: dict[str, Guess]):
        self.lab = lab
        self.first = unknowns_of({name: one.value for name, one in guess.items()})
        self.noise = dict(NOISE)
        self.tests = len(lab.oedometers) + len(lab.triaxials)
        self.spread = np.array(  # standard deviation of each unknown beside the constants
            [FREE] * len(lab.oedometers) + [SPECIMEN] * (len(lab.triaxials) + len(lab.oedometers))
        )
        self.soft = self._soft()
        self.evaluations = 0
        self.steps = 0  # of integration, so far
        self.rows: list[int] = []  # of each curve
        self.kinds: list[str] = []
        self.knowledge = 0  # rows of index tests and of specimens
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
        found: list[MeasuredCurve] = []
        if first:
            steps, found = _compressions(self.lab.oedometers, law, shifts[:first])
            self.steps += steps
        if self.lab.triaxials:
            steps, sheared = _shearings(self.lab.triaxials, law, shifts[first:], first)
            self.steps += steps
            found += sheared
        return found

    def evaluated(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals over their noise, and their derivatives: of all curves, of `knowledge` beside them, of the rest."""
        if self.kept is not None and np.array_equal(self.kept[0], x):
            return self.kept[1:]
        self.evaluations += 1
        count, others = len(NAMES), len(self.spread)
        steps = np.where(x[:count] + STEP * SPAN > HIGH, -STEP, STEP) * SPAN
        sets = np.repeat(x[:count, None], count + 2, axis=1)
        sets[np.arange(count), 1 + np.arange(count)] += steps
        shifts = np.repeat(x[count : count + self.tests, None], count + 2, axis=1)
        shifts[:, -1] += STEP
        constants = constants_of(sets)
        curves = self.curves(constants, shifts)
        values, slopes = [], []
        for curve in curves:
            given = curve.given
            slope = np.zeros((len(given), count + others))
            if curve.test < len(self.lab.oedometers):
                offset = count + self.tests + curve.test
                given = given + x[offset]
                slope[:, offset] = 1.0 / self.noise[curve.kind]
            miss = (given - curve.measured[:, None]) / self.noise[curve.kind]
            miss = np.clip(np.nan_to_num(miss, nan=FAR), -FAR, FAR)
            slope[:, :count] = (miss[:, 1:-1] - miss[:, :1]) / steps
            slope[:, count + curve.test] = (miss[:, -1] - miss[:, 0]) / STEP
            values.append(miss[:, 0])
            slopes.append(slope)
        self.rows, self.kinds = [len(value) for value in values], [curve.kind for curve in curves]
        self.knowledge = len(self.soft) + others
        for name, value, sd in self.soft:
            given = (np.asarray(constants[name]) - value) / sd
            values.append(given[:1])
            slopes.append(np.concatenate([(given[1:-1] - given[0]) / steps, np.zeros(others)])[None])
        values.append(x[count:] / self.spread)
        slopes.append(np.hstack([np.zeros((others, count)), np.diag(1.0 / self.spread)]))
        for curve in curves:  # sand looser than e_i, where the law is as at e_i, is none
            beyond = np.maximum(curve.looseness - LOOSEST, 0.0) / LOOSENESS
            slope = np.zeros((1, count + others))
            slope[0, :count] = (beyond[1:-1] - beyond[0]) / steps
            slope[0, count + curve.test] = (beyond[-1] - beyond[0]) / STEP
            values.append(beyond[:1])
            slopes.append(slope)
        values.append((x[:count] - self.first) / (HELD * SPAN))
        slopes.append(np.hstack([np.diag(1.0 / (HELD * SPAN)), np.zeros((count, others))]))
        self.kept = x.copy(), np.concatenate(values), np.concatenate(slopes)
        return self.kept[1:]

    def residuals(self, x: np.ndarray) -> list[np.ndarray]:
        """Those of each curve, over its noise."""
        values, _ = self.evaluated(x)
        return np.split(values[: sum(self.rows)], np.cumsum(self.rows)[:-1])


def _compressions(tests: list[Oedometer], law: Any, shifts: np.ndarray) -> tuple[int, list[MeasuredCurve]]:
    """First loading of oedometer tests, after the steps of integration."""
    ends = np.log([[test.stress_Pa[0], test.stress_Pa.max()] for test in tests]).T
    e = np.array([[test.void_ratio[0]] for test in tests]) + shifts
    path = oedometer(law, ends, 1.0 - np.sin(np.radians(law.critical_friction_angle_deg)), e)
    found = []
    for number, test in enumerate(tests):
        axial = test.stress_Pa[test.loading]
        radial, given = path.at(number, np.log(axial))
        loose = _looseness(law, (axial[:, None] + 2.0 * radial) / 3.0, given)
        found.append(MeasuredCurve(number, "void ratio", test.void_ratio[test.loading], given, loose))
    return len(path.control), found


def _shearings(tests: list[Triaxial], law: Any, shifts: np.ndarray, first: int) -> tuple[int, list[MeasuredCurve]]:
    """First loading of triaxial tests, q over its largest value, after the steps; the first has this number."""
    ends = np.array([[min(0.0, test.strain[0]), test.strain.max()] for test in tests]).T
    e = np.array([[test.void_ratio] for test in tests]) + shifts
    path = triaxial(law, ends, np.array([test.cell_Pa for test in tests]), e)
    found = []
    for k, test in enumerate(tests):
        axial, given = path.at(k, test.strain[test.loading])
        q, volume = test.deviator_Pa[test.loading], test.volume_strain[test.loading]
        size, known = np.nanmax(q), np.isfinite(q)
        loose = _looseness(law, (axial + 2.0 * test.cell_Pa) / 3.0, given)
        shown = (axial[known] - test.cell_Pa) / size
        found.append(MeasuredCurve(first + k, "deviator", q[known] / size, shown, loose))
        if (known := np.isfinite(volume)).any():
            lost = 1.0 - (1.0 + given[known]) / (1.0 + e[k])
            found.append(MeasuredCurve(first + k, "volume strain", volume[known], lost, loose))
    return len(path.control), found


def _looseness(law: Any, pressure_Pa: np.ndarray, void_ratio: np.ndarray) -> np.ndarray:
    """Largest void ratio over e_i of each set of constants; values x sets."""
    with np.errstate(all="ignore"):
        return np.nan_to_num(np.max(void_ratio / law.void_ratio_limits(pressure_Pa)[2], axis=0), nan=FAR)
