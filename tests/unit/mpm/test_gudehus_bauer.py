"""The law at a point: exact limits, symmetries and guards."""

import math

import numpy as np
import pytest

from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint, wave_speed

SAND = GudehusBauer()


def rate(stress, void_ratio, strain, spin=0.0):
    """Stress rate by a strain so small that one Euler step is exact to round-off."""
    size = 1e-9
    point = StressPoint(SAND, stress, void_ratio)
    return (point.trial(size * np.array(strain), size * spin)[:4] - point.stress) / size


def test_constants_of_karlsruhe_sand():
    assert pytest.approx(3.061862178, rel=1e-9) == SAND.c1
    assert pytest.approx(2.625, rel=1e-9) == SAND.c2
    assert SAND.h_i == pytest.approx(0.190348975, rel=1e-8)


def test_isotropic_compression_started_on_e_i_stays_on_it():
    p = 1e3
    point = StressPoint(SAND, [-p, -p, -p, 0.0], SAND.void_ratio_limits(p)[2])
    for _ in range(2000):
        point.step([-2e-5, -2e-5, -2e-5, 0.0])
    p = -point.stress[:3].mean()
    assert p > 50e3
    assert point.void_ratio == pytest.approx(SAND.void_ratio_limits(p)[2], rel=1e-5)


@pytest.mark.parametrize(
    ("stress", "strain"),
    [
        ((1.0, 1.0, 1.0, -0.5641842), (0.0, 0.0, 0.0, 0.5)),  # s11 = s22 = s33, s12 / s22 = 0.56418 (29.43 deg)
        ((0.6, 1.8, 0.6, 0.0), (0.5, -1.0, 0.5, 0.0)),  # a stress ratio of three
        ((9 / 7, 3 / 7, 9 / 7, 0.0), (-0.5, 1.0, -0.5, 0.0)),
    ],
    ids=["simple shear", "triaxial compression", "triaxial extension"],
)
def test_at_e_c_and_the_critical_stress_the_stress_rate_vanishes(stress, strain):
    p = 50e3
    e_c = SAND.void_ratio_limits(p)[1]
    isotropic = rate([-p, -p, -p, 0.0], e_c, strain)
    assert np.abs(rate(-p * np.array(stress), e_c, strain)).max() < 1e-4 * np.abs(isotropic).max()


@pytest.mark.parametrize(("e", "k0"), [(0.55, 0.361), (0.60, 0.416), (0.75, 0.487), (0.90, 0.523)])
def test_pressure_ratio_at_rest(e, k0):
    assert SAND.rest_pressure_ratio(e) == pytest.approx(k0, abs=6e-4)


@pytest.mark.parametrize(("e", "load", "unload"), [(0.60, 9.56e6, 19.91e6), (0.90, 4.53e6, 15.12e6)])
def test_isotropic_moduli_at_5_kPa(e, load, unload):
    stress = [-5e3, -5e3, -5e3, 0.0]
    assert -rate(stress, e, [0.0, -1.0, 0.0, 0.0])[1] == pytest.approx(load, rel=2e-3)
    assert rate(stress, e, [0.0, 1.0, 0.0, 0.0])[1] == pytest.approx(unload, rel=2e-3)
    c = wave_speed(SAND, stress, e)
    assert c**2 * SAND.grain_density / (1.0 + e) == pytest.approx(unload, rel=2e-3)


def test_wave_speed_bounds_the_stiffness_in_every_direction():
    rng = np.random.default_rng(7)
    for _ in range(60):
        a, b, c = -rng.uniform(1e3, 6e3, 3)
        stress = [a, b, c, rng.uniform(-0.9, 0.9) * math.sqrt(a * b) * 0.8]
        e = rng.uniform(0.53, 1.1)
        bound = wave_speed(SAND, stress, e) ** 2 * SAND.grain_density / (1.0 + e)
        angle = rng.uniform(0, math.pi)
        n = np.array([math.cos(angle), math.sin(angle)])
        turn = rng.uniform(0, math.pi)
        for m in (n, -n, np.array([math.cos(turn), math.sin(turn)])):
            found = rate(stress, e, [n[0] * m[0], n[1] * m[1], 0.0, 0.5 * (n[0] * m[1] + n[1] * m[0])])
            pull = np.array([[found[0], found[3]], [found[3], found[1]]]) @ n
            assert pull @ m < bound * (1 + 1e-6)


def test_stress_rate_does_not_depend_on_time():
    """Three times the strain rate for a third of the time."""
    stress, strain = [-4e3, -9e3, -5e3, 1.5e3], np.array([1.0, -2.0, 0.0, 0.7])
    assert np.allclose(rate(stress, 0.6, 3.0 * strain), 3.0 * rate(stress, 0.6, strain), rtol=1e-5)


def test_response_is_isotropic():
    """Turning stress and strain rate turns the stress rate."""
    angle = 0.6
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])

    def turned(t):
        plane = turn @ np.array([[t[0], t[3]], [t[3], t[1]]]) @ turn.T
        return np.array([plane[0, 0], plane[1, 1], t[2], plane[0, 1]])

    stress, strain = np.array([-4e3, -9e3, -5e3, 1.5e3]), np.array([1.0, -2.0, 0.0, 0.7])
    there = rate(turned(stress), 0.6, turned(strain))
    assert np.allclose(there, turned(rate(stress, 0.6, strain)), rtol=1e-5, atol=1e-5 * np.abs(there).max())


def test_a_rigid_rotation_turns_the_stress_with_it():
    """Jaumann's rate: after a quarter turn the two normal stresses have changed places."""
    point = StressPoint(SAND, [-4e3, -9e3, -5e3, 1e3], 0.6)
    count = 400
    for _ in range(count):
        # W_xy = (L_xy - L_yx) / 2 is negative for a turn to the left
        point.step([0.0, 0.0, 0.0, 0.0], -0.5 * math.pi / count)
    assert np.allclose(point.stress, [-9e3, -4e3, -5e3, -1e3], atol=5.0)
    assert point.void_ratio == pytest.approx(0.6, abs=1e-12)


class TestGuards:
    def test_denser_than_e_d_the_law_stays_finite_and_stiff(self):
        there = rate([-5e3, -5e3, -5e3, 0.0], 0.45, [0.0, -1.0, 0.0, 0.0])
        assert np.isfinite(there).all()
        assert there[1] < 0

    def test_looser_than_e_i_the_stiffness_is_that_at_e_i(self):
        at_limit = rate([-5e3] * 3 + [0.0], SAND.void_ratio_limits(5e3)[2], [-1.0, -1.0, -1.0, 0.0])
        beyond = rate([-5e3] * 3 + [0.0], 1.295, [-1.0, -1.0, -1.0, 0.0])
        assert beyond[0] < 0
        assert abs(beyond[0]) == pytest.approx(abs(at_limit[0]), rel=0.15)

    def test_sand_looser_than_e_i0_carries_nothing(self):
        point = StressPoint(SAND, [-5e3] * 3 + [0.0], 1.5)
        point.step([0.0, -1e-5, 0.0, 0.0])
        assert np.allclose(point.stress, [-SAND.rest_stress] * 3 + [0.0])

    def test_extension_ends_at_rest_stress_and_never_in_tension(self):
        point = StressPoint(SAND, [-2e3, -4e3, -2e3, 0.5e3], 0.6)
        for _ in range(300):
            point.step([0.0, 1e-5, 0.0, 3e-6])
            a, b, c, d = point.stress
            centre, radius = 0.5 * (a + b), math.hypot(0.5 * (a - b), d)
            assert max(centre + radius, c) < 1e-6
        assert np.allclose(point.stress, [-SAND.rest_stress] * 3 + [0.0])

    def test_separated_sand_loads_again_once_it_is_compacted(self):
        point = StressPoint(SAND, [-SAND.rest_stress] * 3 + [0.0], 0.6)
        for _ in range(20):
            point.step([1e-3, 1e-3, 0.0, 0.0])
        assert np.allclose(point.stress[:3], -SAND.rest_stress)
        for _ in range(25):
            point.step([-1e-3, -1e-3, 0.0, 0.0])
        assert point.stress[1] < -1e3
        assert 0.55 < point.void_ratio < 0.62

    def test_oscillating_volume_does_not_pump_the_void_ratio(self):
        point = StressPoint(SAND, [-5e3] * 3 + [0.0], 0.6)
        for _ in range(200):
            point.step([0.0, -1e-4, 0.0, 0.0])
            point.step([0.0, 1e-4, 0.0, 0.0])
        assert point.void_ratio == pytest.approx(0.6, abs=1e-9)  # (1 + x)(1 - x) would lose 3e-6
