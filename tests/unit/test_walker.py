"""Walker's hopper: hand-computed values, equilibrium of the slice and of the whole, and limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from taichi_silo.analysis.theory.walker import WalkerHopper, discharge_factor, filling_factor


def possible(**values):
    """A hopper, or no case where its angles are not possible."""
    try:
        return WalkerHopper(**values)
    except ValueError:
        reject()


hoppers = st.builds(
    possible,
    width_m=st.floats(0.2, 10.0),
    outlet_m=st.floats(0.02, 0.15),
    half_angle_deg=st.floats(5.0, 40.0),
    weight_density_N_per_m3=st.floats(5e3, 2.5e4),
    wall_friction_angle_deg=st.floats(0.0, 35.0),
    transition_stress_Pa=st.floats(0.0, 1e5),
    state=st.sampled_from(["filling", "discharge", 0.7, 1.0, 2.5]),
    section=st.sampled_from(["plane", "round"]),
    internal_friction_angle_deg=st.floats(36.0, 45.0),
    pressure_ratio=st.sampled_from([None, 0.45]),
)

# beta with tan = 0.5, mu = 0.4, gamma = 10 kN/m3, width 2 m: h_h = 1 / 0.5 = 2 m
BETA, PHI_W = np.degrees(np.arctan(0.5)), np.degrees(np.arctan(0.4))
CONE = WalkerHopper(2.0, 1.0, BETA, 10e3, PHI_W, 30e3, "filling", "round")


def test_filling_of_a_cone_and_a_wedge_by_hand():
    # F = 1 - 0.2 / (1 + 0.5/0.4) = 1 - 0.2/2.25 = 0.9111111; n = 2 * 0.8 * 0.4 / 0.5 = 1.28
    # x = 1 m, y = 0.5: y^1.28 = exp(-1.28 * 0.69314718) = exp(-0.88722839) = 0.41179551;
    # sigma_v = 10*2/0.28 * (0.5 - 0.41179551) + 30 * 0.41179551 = 6.3003207 + 12.3538653 = 18.654186 kPa
    # p_n = 0.9111111 * 18.654186 = 16.996036 kPa, p_t = 0.4 p_n = 6.798414 kPa
    assert (CONE.transition_height_m, CONE.outlet_height_m) == pytest.approx((2.0, 1.0))
    assert (CONE.factor, CONE.exponent) == pytest.approx((0.9111111, 1.28), rel=1e-7)
    assert CONE.vertical_stress_Pa(1.0) == pytest.approx(18.654186e3, rel=1e-7)
    assert CONE.normal_stress_Pa(1.0) == pytest.approx(16.996036e3, rel=1e-7)
    assert CONE.shear_stress_Pa(1.0) == pytest.approx(6.798414e3, rel=1e-6)
    assert CONE.transition_normal_stress_Pa == pytest.approx(0.9111111 * 30e3, rel=1e-7)
    # frustum, per pi d: W = 10 * pi/3 * 1 m * (1 + 0.5 + 0.25) / (2 pi) = 2.9166667 kN/m; top 30 * 2/4 = 15 kN/m
    assert (CONE.weight_N_per_m, CONE.top_force_N_per_m) == pytest.approx((10e3 * 1.75 / 6.0, 15e3))
    # wedge: n = 1 * 0.8 * 0.4 / 0.5 = 0.64; y = 0.5: y^0.64 = exp(-0.44361420) = 0.64171295
    # sigma_v = 20/(-0.36) * (0.5 - 0.64171295) + 30 * 0.64171295 = 7.8729417 + 19.2513885 = 27.12433 kPa
    wedge = replace(CONE, section="plane")
    assert wedge.exponent == pytest.approx(0.64)
    assert wedge.vertical_stress_Pa(1.0) == pytest.approx(27.12433e3, rel=1e-6)
    # W = 10 * 1 m * (2 + 1)/2 = 15 kN/m, top 30 * 2 = 60 kN/m
    assert (wedge.weight_N_per_m, wedge.top_force_N_per_m) == pytest.approx((15e3, 60e3))


def test_discharge_factor_by_hand():
    # phi_i = 30, phi_w = 20, beta = 15: asin(0.34202014/0.5) = asin(0.68404029) = 43.160209, eps = 63.160209
    # F = (1 + 0.5 * cos 63.160209) / (1 - 0.5 * cos 93.160209) = (1 + 0.5*0.4514998) / (1 + 0.5*0.0551278)
    #   = 1.2257499 / 1.0275639 = 1.1928698
    assert discharge_factor(15.0, np.tan(np.radians(20.0)), 30.0) == pytest.approx(1.1928698, rel=1e-5)
    # a rough wall counts as the fill: eps = 120, F = (1 - 0.25) / (1 - 0.5 cos 150) = 0.75 / 1.4330127 = 0.5233728
    assert discharge_factor(15.0, 2.0, 30.0) == pytest.approx(0.5233728, rel=1e-6)


@given(st.floats(1.0, 25.0), st.floats(0.01, 0.45), st.floats(28.0, 50.0))
def test_discharge_factor_is_that_of_a_stress_at_passive_yield_which_slides_on_the_wall(beta_deg, mu, phi_deg):
    factor = discharge_factor(beta_deg, mu, phi_deg)
    beta, sin_phi = np.radians(beta_deg), np.sin(np.radians(phi_deg))
    # of the right wall (x right, z up): n into the wall, t down along it; the fill presses with p_n, drags with p_t
    n = np.array([np.cos(beta), -np.sin(beta)])
    t = np.array([-np.sin(beta), -np.cos(beta)])
    normal, shear = factor, mu * factor
    q = 2.0 * _centre(normal, shear, sin_phi) - normal
    stress = normal * np.outer(n, n) + q * np.outer(t, t) + shear * (np.outer(n, t) + np.outer(t, n))
    assert stress[1, 1] == pytest.approx(1.0, rel=1e-9)  # sigma_v
    low, high = np.linalg.eigvalsh(stress)
    assert (high - low) / (high + low) == pytest.approx(sin_phi, rel=1e-9)


def _centre(normal, shear, sin_phi):
    """Centre s <= normal of the circle at yield through (normal, shear): (normal - s)^2 + shear^2 = (s sin_phi)^2."""
    cos2 = 1.0 - sin_phi**2
    return (normal - np.sqrt(normal**2 - cos2 * (normal**2 + shear**2))) / cos2


@given(st.floats(2.0, 60.0), st.floats(0.01, 1.0), st.sampled_from([1, 2]))
def test_exponent_of_filling_is_that_of_the_eurocode(beta, mu, order):
    # EN 1991-4 (6.28): n = S (1 - b) mu cot(beta)
    section = {1: "plane", 2: "round"}[order]
    hopper = WalkerHopper(2.0, 1.0, beta, 1e4, np.degrees(np.arctan(mu)), 0.0, "filling", section)
    assert hopper.exponent == pytest.approx(order * 0.8 * mu / np.tan(np.radians(beta)), rel=1e-9, abs=1e-12)
    assert 0.8 < filling_factor(beta, mu) < 1.0


@settings(deadline=None)
@given(hoppers)
def test_walls_and_outlet_carry_weight_and_top_load(hopper):
    top, bottom = hopper.transition_height_m, hopper.outlet_height_m
    tan = np.tan(np.radians(hopper.half_angle_deg))

    def vertical(log):  # per metre of height and of run, or of circumference at the transition; log x for small outlets
        x = np.exp(log)
        length = 2.0 if hopper.section == "plane" else x / top
        return x * length * (tan * hopper.normal_stress_Pa(x) + hopper.shear_stress_Pa(x))

    carried = quad(vertical, np.log(bottom), np.log(top), epsabs=0.0, epsrel=1e-13, limit=200)[0]
    load = hopper.weight_N_per_m + hopper.top_force_N_per_m
    assert carried + hopper.outlet_force_N_per_m == pytest.approx(load, rel=1e-10)
    walls = 2.0 if hopper.section == "plane" else 1.0
    assert walls * hopper.wall_force_N_per_m == pytest.approx(carried, rel=1e-9, abs=1e-10 * load)


@settings(deadline=None, max_examples=25)
@given(hoppers)
def test_solution_is_that_of_the_slices_equation(hopper):
    gamma, tan = hopper.weight_density_N_per_m3, np.tan(np.radians(hopper.half_angle_deg))
    order = 1 if hopper.section == "plane" else 2

    def slope(x, sigma):  # (A sigma)' + gamma A = F (tan + mu) U sigma, A = x^S, U/A = S / (x tan)
        perimeter = order / (x * tan)
        return hopper.factor * (tan + hopper.wall_friction) * perimeter * sigma - gamma - order / x * sigma

    ends = (hopper.transition_height_m, hopper.outlet_height_m)
    found = solve_ivp(slope, ends, [hopper.transition_stress_Pa], rtol=1e-10, atol=1e-6).y[0, -1]
    assert found == pytest.approx(float(hopper.vertical_stress_Pa(ends[1])), rel=1e-6, abs=1e-3)


@pytest.mark.parametrize(("section", "order", "gap"), [("round", 2, 0.0), ("plane", 1, 1.0)])
def test_printed_exponent_of_the_eurocode_is_out_of_balance_for_a_wedge_only(section, order, gap):
    # n = S (F + F mu cot) - 2 against the equilibrium's - S
    hopper = replace(CONE, section=section)
    assert hopper.exponent - (order * hopper.factor * (1.0 + 0.4 / 0.5) - 2.0) == pytest.approx(gap, abs=1e-12)


@pytest.mark.parametrize("section", ["plane", "round"])
def test_a_fluid_presses_by_its_depth(section):
    fluid = WalkerHopper(2.0, 0.1, BETA, 10e3, 0.0, 5e3, 1.0, section)
    x = np.linspace(fluid.outlet_height_m, fluid.transition_height_m, 9)
    np.testing.assert_allclose(fluid.normal_stress_Pa(x), 5e3 + 10e3 * (2.0 - x), rtol=1e-12)


def test_exponent_of_one_is_the_limit_of_its_neighbours():
    # cone: n = 2 F (1 + 0.8) - 2 = 1 with F = 3 / 3.6; sigma_v(1 m) = (30 + 20 ln 2) / 2 = 21.931472 kPa
    exact = replace(CONE, state=3.0 / 3.6)
    assert exact.vertical_stress_Pa(1.0) == pytest.approx(21.931472e3, rel=1e-7)
    for change in (-1e-9, 1e-9):
        near = replace(CONE, state=3.0 / 3.6 * (1.0 + change))
        assert near.vertical_stress_Pa(1.0) == pytest.approx(21.931472e3, rel=1e-7)


def test_far_below_the_top_the_stress_forgets_it():
    deep = replace(CONE, half_angle_deg=15.0, state="discharge", internal_friction_angle_deg=36.0, outlet_m=0.01)
    x = deep.outlet_height_m
    radial = 10e3 * x / (deep.exponent - 1.0)  # gamma x / (n - 1)
    assert deep.exponent > 2.0
    assert deep.vertical_stress_Pa(x) == pytest.approx(radial, rel=0.01)


def test_shallow_hopper_mobilises_less_friction_and_discharges_as_it_was_filled():
    # steep below tan(beta) = (1 - 0.45) / (2 * 0.4) = 0.6875, beta = 34.51; tan 45 = 1: mu = 0.55 / 2 = 0.275
    steep = replace(CONE, half_angle_deg=34.4, pressure_ratio=0.45)
    shallow = replace(CONE, half_angle_deg=45.0, pressure_ratio=0.45)
    assert steep.is_steep and steep.wall_friction == pytest.approx(0.4)
    assert not shallow.is_steep and shallow.wall_friction == pytest.approx(0.275)
    emptying = replace(shallow, state="discharge", internal_friction_angle_deg=36.0)
    assert emptying.factor == shallow.factor
    edge = replace(CONE, half_angle_deg=np.degrees(np.arctan(0.6875)) + 1e-9, pressure_ratio=0.45)
    assert edge.wall_friction == pytest.approx(0.4)


@pytest.mark.parametrize(
    "wrong",
    [
        {"width_m": 0.0}, {"outlet_m": 3.0}, {"outlet_m": 0.0}, {"half_angle_deg": 90.0}, {"state": -1.0},
        {"state": "rest"}, {"section": "oval"}, {"pressure_ratio": 1.0}, {"transition_stress_Pa": -1.0},
        {"wall_friction_angle_deg": 90.0}, {"weight_density_N_per_m3": float("nan")},
        {"internal_friction_angle_deg": None, "state": "discharge"},
        {"internal_friction_angle_deg": 0.0, "state": "discharge"},
        {"half_angle_deg": 80.0, "internal_friction_angle_deg": 36.0, "state": "discharge"},
    ],
)  # fmt: skip
def test_impossible_hoppers_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        replace(CONE, **wrong)


@pytest.mark.parametrize("height", [0.5, 2.1])
def test_heights_outside_the_hopper_are_refused(height):
    with pytest.raises(ValueError, match="above the apex"):
        CONE.vertical_stress_Pa(height)
