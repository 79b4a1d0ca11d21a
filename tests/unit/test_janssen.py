"""Janssen's theory: tabulated silos, equilibrium, and its limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taichi_silo.analysis.theory.janssen import Janssen, pressure_ratio_from_normal_force

WIDTH, HEIGHT = 0.2, 0.5

# gamma [kN/m3], phi_w [deg], K, z0 [m], sigma_h, tau_w, sigma_v at the bottom [kPa], N, T, P [kN/m]
TABLE = [
    (16.248, 19.0, 0.500, 0.5808, 2.7236, 0.9378, 5.4471, 0.7774, 0.2677, 1.0894),
    (16.248, 19.0, 0.450, 0.6454, 2.5442, 0.8760, 5.6538, 0.7174, 0.2470, 1.1308),
    (16.248, 19.0, 1.000, 0.2904, 3.8751, 1.3343, 3.8751, 1.2339, 0.4249, 0.7750),
    (16.248, 29.43, 0.500, 0.3545, 2.1771, 1.2283, 4.3543, 0.6682, 0.3770, 0.8709),
    (16.248, 42.0, 3.000, 0.0370, 1.8045, 1.6248, 0.6015, 0.8354, 0.7522, 0.1203),
    (13.682, 12.3, 0.500, 0.9173, 2.6369, 0.5749, 5.2739, 0.7188, 0.1567, 1.0548),
    (13.682, 12.3, 1.000, 0.4586, 4.1658, 0.9083, 4.1658, 1.2270, 0.2675, 0.8332),
    (13.682, 29.43, 1.000, 0.1773, 2.2808, 1.2867, 2.2808, 0.8083, 0.4560, 0.4562),
]

fills = st.builds(
    Janssen,
    width_m=st.floats(0.05, 5.0),
    height_m=st.floats(0.05, 20.0),
    weight_density_N_per_m3=st.floats(1e3, 3e4),
    wall_friction_angle_deg=st.floats(0.0, 60.0),
    pressure_ratio=st.floats(0.1, 4.0),
    section=st.sampled_from(["plane", "round"]),
)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row[0]} {row[1]}deg K{row[2]}")
def test_tabulated_silos(row):
    gamma, angle, ratio, *expected = row
    fill = Janssen(WIDTH, HEIGHT, 1e3 * gamma, angle, ratio)
    computed = [
        fill.depth_scale_m,
        *(1e-3 * stress(HEIGHT) for stress in (fill.normal_stress_Pa, fill.shear_stress_Pa, fill.vertical_stress_Pa)),
        *(1e-3 * force for force in (fill.normal_force_N_per_m, fill.shear_force_N_per_m, fill.bottom_force_N_per_m)),
    ]
    rounding = 0.5e-4 + 0.6e-4 * np.array(expected)  # four decimals, and gamma rounded to 3e-5 of itself
    assert np.all(np.abs(np.array(computed) - expected) < rounding)


@settings(deadline=None)
@given(fills)
def test_bottom_and_walls_carry_the_weight(fill):
    walls = 2.0 if fill.section == "plane" else 1.0  # per metre run, per metre of circumference
    carried = fill.bottom_force_N_per_m + walls * fill.shear_force_N_per_m
    assert carried == pytest.approx(fill.weight_N_per_m, rel=1e-11)
    assert fill.vertical_stress_Pa(0.0) == 0.0


@settings(deadline=None)
@given(fills)
def test_wall_forces_are_integrals_of_wall_stresses(fill):
    point, weight = np.polynomial.legendre.leggauss(60)
    # the exponential is resolved near the top, and gone below 40 depth scales
    ends = np.minimum([0.0, 8.0 * fill.depth_scale_m, 40.0 * fill.depth_scale_m, np.inf], fill.height_m)
    force = 0.0
    for low, high in zip(ends[:-1], ends[1:], strict=True):
        depth = low + 0.5 * (high - low) * (point + 1.0)
        force += 0.5 * (high - low) * np.sum(weight * fill.normal_stress_Pa(depth))
    assert force == pytest.approx(fill.normal_force_N_per_m, rel=1e-9)


@settings(deadline=None)
@given(fills)
def test_pressure_ratio_is_found_again_from_the_normal_force(fill):
    rest = (fill.width_m, fill.height_m, fill.weight_density_N_per_m3, fill.wall_friction_angle_deg, fill.section)
    found = pressure_ratio_from_normal_force(fill.normal_force_N_per_m, *rest)
    assert found == pytest.approx(fill.pressure_ratio, rel=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6])
def test_frictionless_walls_leave_a_linear_pressure(angle):
    fill = Janssen(WIDTH, HEIGHT, 16e3, angle, 0.45)
    depth = np.linspace(0.0, HEIGHT, 7)
    np.testing.assert_allclose(fill.normal_stress_Pa(depth), 0.45 * 16e3 * depth, rtol=1e-6)
    assert fill.normal_force_N_per_m == pytest.approx(0.5 * 0.45 * 16e3 * HEIGHT**2, rel=1e-6)
    assert fill.bottom_force_N_per_m == pytest.approx(fill.weight_N_per_m, rel=1e-6)


def test_stresses_saturate_far_below_the_surface():
    fill = Janssen(WIDTH, 100.0, 16e3, 30.0, 0.5)
    assert fill.shear_stress_Pa(100.0) == pytest.approx(16e3 * WIDTH / 2.0)  # two walls carry each slice


def test_a_round_silo_by_hand():
    # d = 4 m, h = 10 m, gamma = 10 kN/m3, mu = 0.5, K = 0.4: A/U = 4/4 = 1 m, z0 = 1 / (0.4 * 0.5) = 5 m,
    # sigma_v(10) = 10 * 5 * (1 - e^-2) = 43.233236 kPa, sigma_h = 17.293294, tau = 8.646647 kPa,
    # per metre of circumference W = 10 * 1 * 10 = 100, P = 43.233236 * 1, T = 100 - P = 56.766764, N = T / 0.5 kN/m
    fill = Janssen(4.0, 10.0, 10e3, np.degrees(np.arctan(0.5)), 0.4, "round")
    assert fill.depth_scale_m == pytest.approx(5.0)
    stresses = (fill.vertical_stress_Pa(10.0), fill.normal_stress_Pa(10.0), fill.shear_stress_Pa(10.0))
    assert stresses == pytest.approx((43.233236e3, 17.293294e3, 8.646647e3))
    assert (fill.weight_N_per_m, fill.bottom_force_N_per_m) == pytest.approx((100e3, 43.233236e3))
    assert (fill.shear_force_N_per_m, fill.normal_force_N_per_m) == pytest.approx((56.766764e3, 113.533528e3))


@settings(deadline=None)
@given(fills)
def test_a_round_silo_twice_as_wide_has_the_stresses_of_a_plane_one(fill):
    rest = (fill.height_m, fill.weight_density_N_per_m3, fill.wall_friction_angle_deg, fill.pressure_ratio)
    wide, narrow = Janssen(2.0 * fill.width_m, *rest, "round"), Janssen(fill.width_m, *rest, "plane")
    depth = np.linspace(0.0, fill.height_m, 5)
    np.testing.assert_allclose(wide.vertical_stress_Pa(depth), narrow.vertical_stress_Pa(depth), rtol=1e-14)
    assert wide.normal_force_N_per_m == pytest.approx(narrow.normal_force_N_per_m, rel=1e-14)
    assert 2.0 * wide.weight_N_per_m == pytest.approx(narrow.weight_N_per_m, rel=1e-14)


CARRIED_BY_FRICTION = 16e3 * WIDTH * HEIGHT / (2 * np.tan(np.radians(19.0)))


@pytest.mark.parametrize("force", [0.0, -1.0, float("nan"), CARRIED_BY_FRICTION])
def test_a_force_beyond_the_theory_is_refused(force):
    with pytest.raises(ValueError, match="no pressure ratio"):
        pressure_ratio_from_normal_force(force, WIDTH, HEIGHT, 16e3, 19.0)


@pytest.mark.parametrize(
    "wrong", [{"width_m": 0.0}, {"pressure_ratio": -0.4}, {"wall_friction_angle_deg": 90.0}, {"section": "oval"}]
)
def test_impossible_fills_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        replace(Janssen(WIDTH, HEIGHT, 16e3, 19.0, 0.45), **wrong)
