"""When plane strain compression can localise: against independent tables with checked traction continuity."""

import math

import pytest

from taichi_silo.mpm.laws import Elastic, GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint
from validation.biaxial.bifurcation import band_sizes, first_bifurcation
from validation.biaxial.bounds import homogeneous


@pytest.mark.parametrize(
    ("void_ratio", "pressure", "angle", "percent", "band"),
    [
        (0.55, 50e3, 57.6, 1.13, 70.0),
        (0.55, 200e3, 50.7, 1.96, 66.8),
        (0.55, 500e3, 46.1, 2.86, 64.5),
        (0.75, 50e3, 34.5, 1.04, 58.5),
        (0.90, 50e3, 28.2, 1.06, 54.8),
    ],
)
def test_first_bifurcation(void_ratio, pressure, angle, percent, band):
    (strain, friction), inclination = first_bifurcation(homogeneous(GudehusBauer(), void_ratio, pressure))
    assert friction == pytest.approx(angle, abs=0.1)
    assert 100 * (1 - math.exp(-strain)) == pytest.approx(percent, abs=0.02)
    assert inclination == pytest.approx(band, abs=0.5)


def test_an_elastic_body_never_localises():
    point = StressPoint(Elastic(1e7, 0.3), [-5e4, -2e5, -1e5, 0.0], 0.6)
    assert band_sizes(point).max() < 1e-6
