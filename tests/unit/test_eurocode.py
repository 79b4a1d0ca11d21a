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
    # mu 0.48 * 1.16^+-1 = 0.5568, 0.413793; K 0.45 * 1.11^+-1 = 0.4995, 0.405405; phi_i 36 * 1.09^+-1 = 39.24, 33.0275
    expected = {
        "mean": (0.48, 0.45, 36.0),
        "wall pressure": (0.4137931, 0.4995, 33.027523),
        "wall friction": (0.5568, 0.4995, 33.027523),
        "bottom load": (0.4137931, 0.4054054, 39.24),
        "hopper filling": (0.4137931, 0.4054054, 33.027523),
        "hopper discharge": (0.4137931, 0.4995, 39.24),
    }
    for load, row in expected.items():
        v = SAND.extremes(load, "D2")
        assert (v.wall_friction, v.pressure_ratio, v.internal_friction_angle_deg) == pytest.approx(row, rel=1e-6)
        assert v.weight_density_N_per_m3 == 16e3
    # a rough wall: 0.57 * 1.16 = 0.6612 is more than tan(33.027523) = 0.650045
    assert SAND.extremes("wall friction", "D3").wall_friction == pytest.approx(0.650045, rel=1e-4)


def test_filling_of_a_slender_silo_by_hand():
    # A/U = 4/4 = 1 m; z0 = 1 / (0.4995 * 0.4137931) = 4.8381745 m; p_ho = 16 / 0.4137931 = 38.666667 kPa
    # z = 10: exp(-2.0668951) = 0.1265782; p_hf = 38.666667 * 0.8734218 = 33.772310 kPa
    assert TALL.slenderness == "slender"
    assert TALL.depth_scale_m() == pytest.approx(4.8381745, rel=1e-6)
    assert TALL.filling_normal_Pa(10.0) == pytest.approx(33.77231e3, rel=1e-5)
    # friction with mu = 0.5568: z0 = 3.5955518 m, p_ho = 16 / 0.5568 = 28.735632, exp(-2.7812143) = 0.0619632
    # p_wf = 0.5568 * 28.735632 * 0.9380368 = 15.008589 kPa; discharge times 1.15 and 1.10
    assert TALL.filling_shear_Pa(10.0) == pytest.approx(15.008589e3, rel=1e-5)
    assert TALL.discharge_factors == pytest.approx((1.15, 1.10))
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
    assert LOW.discharge_factors == (1.0, 1.0)
    assert replace(LOW, section="plane").surface_depth_m == pytest.approx(1.5 * 1.079712, rel=1e-6)


@pytest.mark.parametrize(("section", "width"), [("round", 4.0), ("plane", 2.0)])
def test_a_slender_silo_is_janssens(section, width):
    silo = EurocodeSilo(width, 10.0, section=section)
    v = silo.values("wall pressure")
    angle = np.degrees(np.arctan(v.wall_friction))
    theory = Janssen(width, 10.0, 16e3, angle, v.pressure_ratio, section)
    z = np.linspace(0.0, 10.0, 11)
    np.testing.assert_allclose(silo.filling_normal_Pa(z), theory.normal_stress_Pa(z), rtol=1e-12)
    np.testing.assert_allclose(silo.filling_vertical_Pa(z, "wall pressure"), theory.vertical_stress_Pa(z), rtol=1e-12)


silos = st.builds(
    EurocodeSilo,
    width_m=st.floats(1.0, 30.0),
    height_m=st.floats(13.0, 90.0),
    wall=st.sampled_from(["D1", "D2", "D3"]),
    section=st.sampled_from(["round", "plane"]),
    assessment_class=st.sampled_from([1, 2, 3]),
)


@settings(deadline=None)
@given(silos, st.sampled_from(["mean", "wall pressure", "wall friction", "bottom load"]))
def test_friction_and_vertical_pressure_carry_the_weight(silo, load):
    h, h0 = silo.height_m, silo.surface_depth_m
    turns = [h0 + k * silo.depth_scale_m(load) for k in (0.1, 1.0, 4.0) if h0 + k * silo.depth_scale_m(load) < h]
    carried = quad(lambda z: silo.filling_shear_Pa(z, load), h0, h, epsrel=1e-12, limit=200, points=turns or None)[0]
    carried = carried / silo.hydraulic_radius_m + silo.filling_vertical_Pa(h, load)  # over the area
    assert carried == pytest.approx(16e3 * h, rel=1e-9)


def test_a_rectangle_lies_between_a_square_and_two_walls():
    # a = 3, b = 2: A/U = 6/10 = 0.6 m; square: 2/4; long: 2/2
    assert EurocodeSilo(2.0, 5.0, section="rectangular", length_m=3.0).hydraulic_radius_m == pytest.approx(0.6)
    assert EurocodeSilo(2.0, 5.0, section="rectangular", length_m=2.0).hydraulic_radius_m == pytest.approx(0.5)
    long = EurocodeSilo(2.0, 5.0, section="rectangular", length_m=1e9)
    assert long.hydraulic_radius_m == pytest.approx(EurocodeSilo(2.0, 5.0, section="plane").hydraulic_radius_m)


@pytest.mark.parametrize(
    ("height", "name"),
    [
        (8.0, "slender"),
        (7.99, "intermediate"),
        (4.01, "intermediate"),
        (4.0, "squat"),
        (1.61, "squat"),
        (1.6, "retaining"),
    ],
)
def test_slenderness(height, name):
    assert EurocodeSilo(4.0, height).slenderness == name


@given(st.sampled_from([1, 2, 3]), st.floats(0.0, 2.0))
def test_discharge_factors_are_continuous(kind, off):
    for edge in (4.0, 8.0):
        low, high = (
            EurocodeSilo(4.0, edge + step, assessment_class=kind, outlet_eccentricity_m=off).discharge_factors
            for step in (-1e-9, 1e-9)
        )
        assert low == pytest.approx(high, abs=1e-8)


def test_discharge_factors_by_hand():
    # class 1, e_o = 0.5, d = 4: 1 + 0.4 * 0.125 = 1.05; C_h = 1.15 + 1.5 * 1.05 * 0.4 = 1.78; C_w = 1.4 * 1.05 = 1.47
    first = replace(TALL, assessment_class=1, outlet_eccentricity_m=0.5)
    assert first.discharge_factors == pytest.approx((1.78, 1.47))
    # intermediate, h_c/d_c = 1.5, C_S = 0.5: 1.075, 1.05; class 1: 1 + (0.15 + 0.63)/2 = 1.39, 1 + 0.4*1.175/2 = 1.235
    assert replace(TALL, height_m=6.0).discharge_factors == pytest.approx((1.075, 1.05))
    assert replace(first, height_m=6.0).discharge_factors == pytest.approx((1.39, 1.235))
    assert replace(first, unloading="top").discharge_factors == (1.0, 1.0)


def test_patch_factors_by_hand():
    # h_c/d_c = 2.5: 1 - exp(-2.25) = 0.8946008; e_f = 0.4: E = 0.2, 1 + 2 E^2 = 1.08; C_pf = 0.21*0.4*1.08*0.8946008
    silo = replace(TALL, filling_eccentricity_m=0.4, outlet_eccentricity_m=0.8)
    assert silo.filling_patch_factor == pytest.approx(0.0811582, rel=1e-5)
    # e = 0.8: E = 0.4, 1.32: C_pe = 0.42 * 0.4 * 1.32 * 0.8946008 = 0.1983867
    assert silo.discharge_patch_factor == pytest.approx(0.1983867, rel=1e-5)
    # h_c/d_c = 1.1, E = 0.4: 0.272 * 0.4 * 0.5 = 0.0544; squat 0.5 with E = 0: none
    assert replace(silo, height_m=4.4).discharge_patch_factor == pytest.approx(0.0544)
    assert replace(TALL, height_m=2.0).discharge_patch_factor == 0.0
    assert replace(TALL, height_m=2.0).filling_patch_factor == 0.0
    assert TALL.patch_height_m == pytest.approx(0.7853982)


def test_limits_are_told():
    assert TALL.limits() == []
    assert "h_b/d_c" in EurocodeSilo(1.0, 9.0, hopper_height_m=1.0).limits()[0]
    assert len(EurocodeSilo(61.0, 101.0).limits()) == 2
    assert "grains" in EurocodeSilo(1.0, 3.0, grain_size_m=0.03).limits()[0]
    assert "parallel" in EurocodeSilo(1.0, 3.0, section="plane").limits()[0]
    assert "5.2.4" in EurocodeSilo(1.0, 3.0, outlet_eccentricity_m=0.3).limits()[0]


def test_an_outlet_far_from_the_axis_opens_a_channel():
    far = replace(TALL, outlet_eccentricity_m=1.5)
    channel = far.flow_channel(0.6)
    assert channel.radius_m == 2.0 and channel.internal_friction_angle_deg == pytest.approx(39.24)
    assert channel.static_normal_Pa(7.0) == pytest.approx(float(far.filling_normal_Pa(7.0)))
    with pytest.raises(ValueError, match="outlet_eccentricity_m must be above 0.25 d_c, got 0.25 d_c"):
        replace(far, outlet_eccentricity_m=1.0).flow_channel(0.6)
    for change in ({"section": "plane"}, {"height_m": 6.0}, {"assessment_class": 1}):
        with pytest.raises(ValueError, match="round, slender and of class 2 or 3"):
            replace(far, **change).flow_channel(0.6)


@pytest.mark.parametrize(
    "wrong",
    [
        {"width_m": 0.0}, {"height_m": float("nan")}, {"section": "oval"}, {"assessment_class": 4},
        {"unloading": "side"}, {"length_m": 5.0}, {"outlet_eccentricity_m": 2.1}, {"grain_size_m": -1.0},
        {"wall": "D4"},
    ],
)  # fmt: skip
def test_impossible_silos_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        replace(TALL, **wrong)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"wall_frictions": (0.4, 0.5)}, "wall_frictions"), ({"pressure_ratio": 0.0}, "pressure_ratio"),
        ({"wall_friction_factor": 0.9}, "wall_friction_factor"), ({"angle_of_repose_deg": 90.0}, "angles"),
        ({"lower_weight_density_N_per_m3": 17e3}, "weight densities"),
    ],
)  # fmt: skip
def test_impossible_solids_are_refused(wrong, words):
    with pytest.raises(ValueError, match=words):
        replace(SAND, **wrong)


def test_what_is_not_covered_is_refused():
    with pytest.raises(ValueError, match="retaining"):
        EurocodeSilo(4.0, 1.0).filling_normal_Pa(0.5)
    with pytest.raises(ValueError, match=r"depth_m must be in \[0, 10.0\]"):
        TALL.filling_normal_Pa(10.1)
    with pytest.raises(ValueError, match="load must be one of"):
        TALL.filling_normal_Pa(1.0, "snow")
