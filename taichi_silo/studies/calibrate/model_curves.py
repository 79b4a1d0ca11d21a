"""What the law gives beside measured curves, over the whole test, with unloading; which sign a volume strain has."""

from dataclasses import replace

import numpy as np

from taichi_silo.show.figures.calibration import Compression, Shearing
from taichi_silo.studies.calibrate.closed_formulas import USUAL, jaky
from taichi_silo.studies.calibrate.fit import Fit
from taichi_silo.studies.calibrate.lab_tests import Laboratory, Oedometer, Triaxial
from taichi_silo.studies.calibrate.paths import Curve, Law, oedometer, triaxial

TURN = 0.1  # share of the whole range by which a test must go back to have turned
MOST_TURNS = 20
OPPOSITE = -0.5  # correlation of a volume strain with what the law gives, below which its sign is the other one
HARDNESSES_PA = 2e7, 2e10  # a tenth of the least and some three times the largest of the published sands


def compressions(lab: Laboratory, fit: Fit) -> list[Compression]:
    """Measured and computed curves of the oedometer tests, the latter with the offset of the former."""
    found = []
    for test in lab.oedometers:
        control, _, e = followed_oedometer(test, fit.constants, fit.void_ratios[test.name])
        e = e + fit.offsets[test.name]
        found.append(Compression(test.name, test.stress_Pa, test.void_ratio, test.loading, np.exp(control), e))
    return found


def shearings(lab: Laboratory, fit: Fit) -> list[Shearing]:
    """Measured and computed curves of the triaxial tests."""
    found = []
    for test in lab.triaxials:
        first = fit.void_ratios[test.name]
        strain, axial, e = followed_triaxial(test, fit.constants, first)
        label = f"{test.name}: {test.cell_Pa / 1e3:.0f} kPa, $e_0$ = {first:.3f}"
        measured = (test.strain, test.deviator_Pa, test.volume_strain)
        found.append(Shearing(label, *measured, strain, axial - test.cell_Pa, 1.0 - (1.0 + e) / (1.0 + first)))
    return found


def followed_oedometer(test: Oedometer, constants: dict[str, float], void_ratio: float) -> tuple[np.ndarray, ...]:
    """Logarithm of the axial stress, radial stress [Pa] and void ratio along a test."""
    turns = turning_points(np.log(test.stress_Pa))[:, None]
    ratio = np.array([[jaky(constants["critical_friction_angle_deg"])]])
    return _line(oedometer(Law(**constants), turns, ratio, np.array([[void_ratio]])))


def followed_triaxial(test: Triaxial, constants: dict[str, float], void_ratio: float) -> tuple[np.ndarray, ...]:
    """Axial strain, axial stress [Pa] and void ratio along a test."""
    turns = turning_points(np.concatenate([[0.0], test.strain]))[:, None]
    return _line(triaxial(Law(**constants), turns, np.array([test.cell_Pa]), np.array([[void_ratio]])))


def with_signs(lab: Laboratory, constants: dict[str, float]) -> Laboratory:
    """The tests, with volume strains turned that are plainly the other way than what the law gives.

    Laboratories count loss or gain of volume as positive; dense sand gains, loose sand loses, as far as its hardness is
    that of a sand. A first value from a few noisy points may be so far off that the law does the opposite.
    """
    tests, remarks = [], list(lab.remarks)
    low, high = HARDNESSES_PA
    if not low <= constants["granular_hardness_Pa"] <= high:
        constants = constants | {name: USUAL[name] for name in ("granular_hardness_Pa", "n")}
    for test in lab.triaxials:
        known = np.isfinite(test.volume_strain)
        if not test.sign_known and known.any():
            strain, _, e = followed_triaxial(test, constants, test.void_ratio)
            given = np.interp(test.strain[known], strain, 1.0 - (1.0 + e) / (1.0 + test.void_ratio))
            there = test.volume_strain[known]
            size = float(np.sqrt(np.sum(given**2) * np.sum(there**2)))
            if np.sum(given * there) < OPPOSITE * size:
                test = replace(test, volume_strain=-test.volume_strain)
                remarks.append(f"{test.name}: read with gain of volume as positive, as the law gives it")
        tests.append(test)
    return replace(lab, triaxials=tests, remarks=remarks)


def turning_points(values: np.ndarray) -> np.ndarray:
    """First value, values at which they turn, last value; small steps back are left out."""
    least = TURN * float(np.ptp(values))
    found, extreme, way = [float(values[0])], float(values[0]), 0.0
    for value in map(float, values[1:]):
        if way == 0.0:
            way = float(np.sign(value - extreme)) if abs(value - extreme) > least else 0.0
            extreme = value if way else extreme
        elif (value - extreme) * way > 0.0:
            extreme = value
        elif (extreme - value) * way > least and len(found) < MOST_TURNS:
            found.append(extreme)
            extreme, way = value, -way
    return np.array([*found, extreme if way else float(values[-1])])


def _line(path: Curve) -> tuple[np.ndarray, ...]:
    return path.control[:, 0], path.stress_Pa[:, 0, 0], path.void_ratio[:, 0, 0]
