"""EN 1991-4: hand-computed values, equilibrium, continuity between classes of slenderness, limits of validity."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from taichi_silo.analysis.theory.eurocode import SAND, EurocodeSilo
from taichi_silo.analysis.theory.janssen import Janssen

TALL = EurocodeSilo(4.0, 10.0)  # slender: h_c/d_c = 2.5
LOW = EurocodeSilo(8.0, 6.0)  # squat: 0.75


def test_extreme_values_of_sand_by_hand():
    # mu 0.48 * 1.16^+-1 = 0.5568, 0.413793; K 0.45 * 1.11^+-1 = 0.4995, 0.405405
    assert SAND.extremes("wall pressure", "D2") == pytest.approx((0.4137931, 0.4995), rel=1e-6)
    assert SAND.extremes("wall friction", "D2") == pytest.approx((0.5568, 0.4995), rel=1e-6)
    assert SAND.extremes("bottom load", "D2") == pytest.approx((0.4137931, 0.4054054), rel=1e-6)
    # a rough wall: 0.57 * 1.16 = 0.6612 is more than tan(36 / 1.09) = tan(33.027523) = 0.650045
    assert SAND.extremes("wall friction", "D3")[0] == pytest.approx(0.650045, rel=1e-4)


def test_filling_of_a_slender_silo_by_hand():
    # A/U = 4/4 = 1 m; z0 = 1 / (0.4995 * 0.4137931) = 4.8381745 m; p_ho = 16 / 0.4137931 = 38.666667 kPa
    # z = 10: exp(-2.0668951) = 0.1265782; p_hf = 38.666667 * 0.8734218 = 33.772310 kPa
    assert TALL.slenderness == "slender"
    assert TALL.depth_scale_m() == pytest.approx(4.8381745, rel=1e-6)
    assert TALL.filling_normal_Pa(10.0) == pytest.approx(33.77231e3, rel=1e-5)
    # friction with mu = 0.5568: z0 = 3.5955518 m, p_ho = 16 / 0.5568 = 28.735632, exp(-2.7812143) = 0.0619632
    # p_wf = 0.5568 * 28.735632 * 0.9380368 = 15.008589 kPa; discharge times 1.15 and 1.10
    assert TALL.filling_shear_Pa(10.0) == pytest.approx(15.008589e3, rel=1e-5)
    assert TALL.discharge_normal_Pa(10.0) == pytest.approx(1.15 * 33.77231e3, rel=1e-5)
    assert TALL.discharge_shear_Pa(10.0) == pytest.approx(1.10 * 15.008589e3, rel=1e-5)


def test_filling_of_a_squat_silo_by_hand():
    # h0 = 8/6 tan 39 = 1.0797120 m; A/U = 2; z0 = 9.6763490; n = -1.8097840 * (1 - 0.1115826) = -1.6078436
    # z = 6: w = 1 + 4.920288/8.596637 = 1.5723513; Y_R = 1 - w^n = 1 - exp(-1.6078436 * 0.4525723) = 0.5169649
    # p_ho = 16 * 2 / 0.4137931 = 77.333333; p_hf = 39.978620 kPa
    assert LOW.slenderness == "squat"
    assert LOW.surface_depth_m == pytest.approx(1.079712, rel=1e-6)
    assert LOW.filling_normal_Pa(6.0) == pytest.approx(39.97862e3, rel=1e-5)
    assert LOW.filling_normal_Pa(1.0) == 0.0  # above the contact
    assert replace(LOW, section="plane").surface_depth_m == pytest.approx(1.5 * 1.079712, rel=1e-6)


@pytest.mark.parametrize(("section", "width"), [("round", 4.0), ("plane", 2.0)])
def test_a_slender_silo_is_janssens(section, width):
    silo = EurocodeSilo(width, 10.0, section=section)
    mu, ratio = SAND.extremes("wall pressure", "D2")
    theory = Janssen(width, 10.0, 16e3, np.degrees(np.arctan(mu)), ratio, section)
    z = np.linspace(0.0, 10.0, 11)
    np.testing.assert_allclose(silo.filling_normal_Pa(z), theory.normal_stress_Pa(z), rtol=1e-12)
    np.testing.assert_allclose(silo.filling_vertical_Pa(z, "wall pressure"), theory.vertical_stress_Pa(z), rtol=1e-12)


silos = st.builds(
    EurocodeSilo,
    width_m=st.floats(1.0, 30.0),
    height_m=st.floats(13.0, 90.0),
    wall=st.sampled_from(["D1", "D2", "D3"]),
    section=st.sampled_from(["round", "plane"]),
)


@settings(deadline=None)
@given(silos, st.sampled_from(["wall pressure", "wall friction", "bottom load"]))
def test_friction_and_vertical_pressure_carry_the_weight(silo, load):
    h, h0 = silo.height_m, silo.surface_depth_m
    turns = [h0 + k * silo.depth_scale_m(load) for k in (0.1, 1.0, 4.0) if h0 + k * silo.depth_scale_m(load) < h]
    carried = quad(lambda z: silo.filling_shear_Pa(z, load), h0, h, epsrel=1e-12, limit=200, points=turns or None)[0]
    carried = carried / silo.hydraulic_radius_m + silo.filling_vertical_Pa(h, load)  # over the area
    assert carried == pytest.approx(16e3 * h, rel=1e-9)


@pytest.mark.parametrize(
    ("height", "name", "factors"),
    [
        (8.0, "slender", (1.15, 1.10)),
        (7.9999999, "intermediate", (1.15, 1.10)),  # continuous
        (6.0, "intermediate", (1.075, 1.05)),  # C_S = 0.5
        (4.0000001, "intermediate", (1.0, 1.0)),
        (4.0, "squat", (1.0, 1.0)),
        (1.61, "squat", (1.0, 1.0)),
        (1.6, "retaining", (1.0, 1.0)),
    ],
)
def test_slenderness_and_discharge_factors(height, name, factors):
    assert EurocodeSilo(4.0, height).slenderness == name
    assert EurocodeSilo(4.0, height).discharge_factors == pytest.approx(factors, abs=1e-7)


def test_limits_are_told():
    assert TALL.limits() == []
    assert "h_b/d_c" in EurocodeSilo(1.0, 10.0).limits()[0]
    assert len(EurocodeSilo(61.0, 101.0).limits()) == 2
    assert "parallel" in EurocodeSilo(1.0, 3.0, section="plane").limits()[0]
    assert "5.2.4" in EurocodeSilo(1.0, 3.0, outlet_eccentricity_m=0.3).limits()[0]


def test_what_is_not_covered_is_refused():
    with pytest.raises(ValueError, match="retaining"):
        EurocodeSilo(4.0, 1.0).filling_normal_Pa(0.5)
    with pytest.raises(ValueError, match=r"depth_m must be in \[0, 10.0\]"):
        TALL.filling_normal_Pa(10.1)
