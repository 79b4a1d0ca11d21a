"""The measure of a shear band on bands that are known, and when and how sand can localise."""

import math

import numpy as np
import pytest

from taichi_silo.mpm.laws import Elastic, GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint
from validation.biaxial.band import shear_band
from validation.biaxial.bifurcation import band_sizes, first_bifurcation
from validation.biaxial.bounds import homogeneous

SPACING = 1.0e-3


def specimen(angle_deg, thickness_m, mirrored=False, noise=0.0, peak=0.6, seed=0):
    """Strain that is `thickness_m` wide at half of its peak, and a void ratio above 0.70 on as wide a part."""
    x, y = np.meshgrid((np.arange(40) + 0.5) * SPACING, (np.arange(140) + 0.5) * SPACING)
    place = np.stack([x.ravel(), y.ravel()], axis=1)
    angle = np.radians(180.0 - angle_deg if mirrored else angle_deg)
    distance = (place - [0.02, 0.08]) @ np.array([-np.sin(angle), np.cos(angle)])
    sharp = 2.0 * np.sqrt(np.log(2.0)) / thickness_m
    bell = np.exp(-((distance * sharp) ** 2))
    rng = np.random.default_rng(seed)
    strain = 0.02 + peak * bell * (1.0 + noise * rng.normal(size=len(bell)))
    return place, strain, 0.55 + 0.30 * bell


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(("angle", "thickness"), [(55.0, 7.5e-3), (50.0, 5e-3), (65.0, 10e-3)])
def test_thickness_and_inclination_of_a_known_band(angle, thickness, mirrored):
    place, strain, void_ratio = specimen(angle, thickness, mirrored)
    band = shear_band(place, strain, void_ratio, SPACING)
    assert band.found
    assert band.inclination_deg == pytest.approx(angle, abs=0.5)
    assert band.thickness_m.median == pytest.approx(thickness, abs=0.6 * SPACING)
    assert band.loose_thickness_m.median == pytest.approx(thickness, abs=0.6 * SPACING)
    assert band.strain.median == pytest.approx(0.6, rel=0.05)


def test_noise_widens_the_spread_and_leaves_the_median():
    quiet, noisy = (shear_band(*specimen(56.0, 7e-3, noise=n), SPACING) for n in (0.0, 0.3))
    assert noisy.inclination_error_deg > quiet.inclination_error_deg
    assert noisy.thickness_m.upper - noisy.thickness_m.lower > quiet.thickness_m.upper - quiet.thickness_m.lower
    assert noisy.inclination_deg == pytest.approx(56.0, abs=1.5)
    assert noisy.thickness_m.median == pytest.approx(7e-3, abs=1.5 * SPACING)


def test_of_two_bands_the_stronger_is_measured():
    place, strong, void_ratio = specimen(55.0, 6e-3)
    _, weak, _ = specimen(55.0, 6e-3, mirrored=True, peak=0.2)
    band = shear_band(place, np.maximum(strong, weak), void_ratio, SPACING)
    rising = band.middles[-1] - band.middles[0]
    assert rising[0] * rising[1] > 0.0
    assert band.inclination_deg == pytest.approx(55.0, abs=1.0)


def test_homogeneous_and_weakly_varying_strain_is_no_band():
    place, strain, void_ratio = specimen(55.0, 7e-3, peak=0.0)
    assert not shear_band(place, strain, void_ratio, SPACING).found
    assert not shear_band(place, strain + 0.05 * place[:, 1] / 0.14, void_ratio, SPACING).found
    place, strain, void_ratio = specimen(55.0, 7e-3)
    band = shear_band(place, strain, void_ratio - 0.2, SPACING)  # a band that has not dilated to 0.70
    assert band.found and band.loose_thickness_m.median == 0.0


def test_stations_without_any_strain_say_nothing_and_a_spot_is_no_band():
    place, _, void_ratio = specimen(55.0, 7e-3)
    spot = np.where(np.linalg.norm(place - [0.02, 0.07], axis=1) < 0.008, 0.5, 0.0)
    band = shear_band(place, spot, void_ratio, SPACING)
    assert not band.found or len(band.middles) < len(band.stations)


@pytest.mark.long
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
