"""Bounds for a biaxial test that follow from the law alone."""

import math

import numpy as np

from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.studies.element_tests import TESTS, friction_angle_deg, through_point
from validation.biaxial.bifurcation import first_bifurcation
from validation.biaxial.scene import BiaxialScene


def bounds(void_ratio: float, pressure_Pa: float, scene: BiaxialScene) -> dict:
    """Peak of homogeneous sand, first bifurcation and the angle of its band, and Roscoe's angle."""
    law = scene.sand.model_copy(update={"void_ratio": void_ratio}).skeleton()
    test = TESTS["plane-strain"]
    rows = np.array(list(through_point(test, law, void_ratio, pressure_Pa, 0.1)))
    peak = int(np.argmax(rows[:, 6]))
    has_peak = peak < len(rows) - 1
    # the dilatancy angle at the peak, from volume and axial strain: sin psi = -(d1 + d3) / (d1 - d3)
    found = {}
    if has_peak:
        found["homogeneous_peak_deg"] = float(rows[peak, 6])
        found["homogeneous_peak_at"] = 1.0 - math.exp(-rows[peak, 0])
        swell = np.log((1.0 + rows[peak + 1, 5]) / (1.0 + rows[peak - 1, 5]))
        axial = rows[peak + 1, 0] - rows[peak - 1, 0]
        lateral = axial + swell
        found["roscoe_deg"] = 45.0 + 0.5 * math.degrees(math.asin((lateral - axial) / (lateral + axial)))
    first = first_bifurcation(homogeneous(law, void_ratio, pressure_Pa))
    if first is not None:
        (strain, angle), band = first
        found |= {"bifurcation_deg": angle, "bifurcation_at": 1.0 - math.exp(-strain), "bifurcation_band_deg": band}
    return found


def homogeneous(law, void_ratio: float, pressure_Pa: float):
    """States of homogeneous compression: ((strain, friction angle), point)."""
    point = StressPoint(law, (-pressure_Pa, -pressure_Pa, -pressure_Pa, 0.0), void_ratio)
    for number in range(1, 1001):
        point.step_mixed((3e-5, -1e-4, 0.0, 0.0), 0.0, 0, -pressure_Pa)
        yield (1e-4 * number, friction_angle_deg(point.stress)), point
