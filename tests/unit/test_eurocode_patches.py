"""EN 1991-4: patch loads, their uniform increase, flow channels at the wall, and the envelope of all loads."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from scipy.integrate import quad, solve_ivp

from taichi_silo.analysis.theory.eurocode import patch_loads as patches
from taichi_silo.analysis.theory.eurocode.flow_channel import FlowChannel, channels
from taichi_silo.analysis.theory.eurocode.load_cases import depth_table, load_cases
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.runs.eurocode import solids

WHEAT = solids()["wheat"]
SILO = EurocodeSilo(10.0, 30.0, WHEAT, "D3", filling_eccentricity_m=1.0)
FAR = replace(SILO, outlet_eccentricity_m=3.0, action_class=3)


def test_factors_by_hand():
    # E = 2 * 1 / 10 = 0.2; 1 + 2 * 0.04 = 1.08; 1 - exp(-1.5 * 2) = 0.9502129
    # 0.21 * 0.5 * 1.08 * 0.9502129 = 0.1077541
    assert patches.filling_factor(SILO) == pytest.approx(0.1077541, rel=1e-6)
    assert patches.discharge_factor(SILO) == pytest.approx(2.0 * 0.1077541, rel=1e-6)
    # h_c/d_c = 1.1: 0.272 * 0.5 * (0.1 + 0.2) = 0.0408
    assert patches.discharge_factor(replace(SILO, height_m=11.0)) == pytest.approx(0.0408, rel=1e-9)
    # an outlet farther off than the heap counts on discharge only: E = 0.6, 1.72
    assert patches.filling_factor(FAR) == pytest.approx(0.1077541, rel=1e-6)
    assert patches.discharge_factor(FAR) == pytest.approx(0.42 * 0.5 * 1.72 * 0.9502129, rel=1e-6)


@pytest.mark.parametrize("change", [{"action_class": 1}, {"height_m": 3.0}])
def test_small_and_retaining_silos_have_no_patch(change):
    silo = replace(SILO, **change)
    assert patches.patch_loads(silo, None) == []
    assert patches.uniform_increase(silo, "discharge", 0.01) is None


def test_a_squat_silo_filled_in_the_middle_has_no_patch():
    assert patches.patch_loads(replace(SILO, height_m=9.0, filling_eccentricity_m=0.0), None) == []


def test_the_factor_of_discharge_jumps_where_the_standard_changes_its_formula():
    """0.272 * 0.2 = 0.0544 continues 0.21 (1 - exp(-0.3)) = 0.0544, half of what 0.42 gives above 1.2."""
    low = replace(SILO, height_m=12.0, filling_eccentricity_m=0.0)
    above = patches.discharge_factor(replace(low, height_m=12.0 + 1e-9))
    assert above / patches.discharge_factor(low) == pytest.approx(2.0, abs=2e-3)


def test_the_patch_of_a_thin_wall_pushes_to_one_side_with_its_force():
    patch = patches.patch_load(SILO, "discharge", "thin-walled")
    assert patch.depth_m == min(SILO.depth_scale_m(), 15.0)  # z_p
    assert patch.height_m == pytest.approx(np.pi * 10.0 / 16.0)
    pushed = quad(lambda a: patch.pressure_at_Pa(np.degrees(a)) * np.cos(a) * 5.0, 0.0, 2.0 * np.pi)[0]
    assert pushed * patch.height_m == pytest.approx(patch.force_N, rel=1e-9)
    assert patch.pressure_Pa == pytest.approx(0.2155082 * float(SILO.discharge_normal_Pa(patch.depth_m)), rel=1e-6)


def test_the_patch_of_a_thick_wall_adds_nothing_to_the_mean_pressure():
    patch = patches.patch_load(SILO, "filling", "thick-walled")
    angles = np.arange(0.5, 360.0, 1.0) + 0.25  # no edge lies on one of them
    pressures = np.array([patch.pressure_at_Pa(angle) for angle in np.repeat(angles, 1)])
    fine = np.arange(0.0, 360.0, 0.01) + 0.005
    mean = np.mean([patch.pressure_at_Pa(angle) for angle in fine])
    assert mean == pytest.approx(0.0, abs=1e-9 * patch.pressure_Pa)
    assert pressures.max() == patch.pressure_Pa and pressures.min() == -patch.pressure_Pa / 7.0
    assert patch.force_N == pytest.approx(patch.height_m**2 * patch.pressure_Pa)


def test_walls_are_thin_or_thick_by_their_thickness():
    assert patches.kinds(SILO, 0.049) == ("thin-walled",)  # d/t = 204
    assert patches.kinds(SILO, 0.051) == ("thick-walled",)  # 196
    assert patches.kinds(SILO, None) == ("thin-walled", "thick-walled")
    assert patches.kinds(replace(SILO, section="plane"), 0.01) == ("band",)


def test_a_uniform_increase_stands_for_the_patch_in_class_2():
    factor = patches.filling_factor(SILO)
    assert patches.uniform_increase(SILO, "filling", 0.02) == (
        1.0 + 5.5 * factor,
        1.0 + factor,
    )  # zeta = 0.5 + 0.01 * 500
    assert patches.uniform_increase(SILO, "filling", 0.25) == (1.0 + factor, 1.0 + factor)  # at least 1
    assert patches.uniform_increase(SILO, "filling", None) is None
    assert patches.uniform_increase(replace(SILO, action_class=3), "filling", 0.02) is None
    band = replace(SILO, section="plane", length_m=12.0)
    assert patches.uniform_increase(band, "filling", None) == (1.0 + 0.36 * factor, 1.0 + 0.36 * factor)


def test_a_published_channel_in_wheat():
    # doi 10.2478/sgem-2018-0043: d 10 m, wall D3, r_c = 0.6 r: theta_c = 22.3 degrees
    (channel,) = [one for one in channels(FAR) if one.radius_share == 0.6]
    assert channel.contact_deg == pytest.approx(22.3, abs=0.05)


@pytest.mark.parametrize("wall", ["D1", "D2", "D3"])
@pytest.mark.parametrize("name", solids())
def test_the_channel_is_what_two_circles_share(name, wall):
    silo = replace(FAR, solid=solids()[name], wall=wall)
    for channel in channels(silo):
        r, own = 5.0, channel.radius_share * 5.0
        whole = shapely.Point(0.0, 0.0).buffer(r, 2000)
        inside = shapely.Point(channel.eccentricity_m, 0.0).buffer(own, 2000).intersection(whole)
        area, wall_m, solid_m = channel.geometry
        assert area == pytest.approx(inside.area, rel=1e-5)
        assert wall_m + solid_m == pytest.approx(inside.length, rel=1e-5)
        assert 0.0 < channel.contact_deg < 60.0


@pytest.mark.parametrize("share", [0.25, 0.4, 0.6])
def test_friction_and_pressure_carry_the_channel_s_weight(share):
    # d(p_v A_c)/dz = gamma A_c - (U_wc mu + U_sc tan(phi_i)) K p_v
    channel = FlowChannel(FAR, share)
    area, wall, solid = channel.geometry
    values = FAR.values("hopper discharge")
    drag = wall * values.wall_friction + solid * np.tan(np.radians(values.internal_friction_angle_deg))
    found = solve_ivp(
        lambda z, p: 9e3 - drag * values.pressure_ratio * p / area, (0.0, 30.0), [0.0], rtol=1e-10, atol=1e-6
    )
    assert channel.normal_Pa(30.0, 0.0) == pytest.approx(values.pressure_ratio * found.y[0, -1], rel=1e-7)


def test_what_the_channel_does_not_press_its_edges_do():
    channel = FlowChannel(FAR, 0.4)
    theta = channel.contact_deg
    inside, beside, far = (float(channel.normal_Pa(20.0, angle)) for angle in (0.0, 1.5 * theta, 180.0))
    assert inside + beside == pytest.approx(2.0 * far)
    assert inside < far == pytest.approx(float(FAR.filling_normal_Pa(20.0)))
    assert channel.normal_Pa(20.0, -1.5 * theta) == beside == channel.normal_Pa(20.0, 360.0 - 1.5 * theta)


def test_channels_are_for_far_outlets_of_round_silos_of_class_2_and_3():
    assert [one.radius_share for one in channels(FAR)] == [0.25, 0.4, 0.6]
    (simple,) = channels(replace(FAR, action_class=2))
    assert (simple.contact_deg, simple.clause) == (35.0, "5.2.4.2")
    assert [float(simple.normal_Pa(20.0, angle)) for angle in (34.0, 69.0)] == [
        0.0,
        2.0 * float(FAR.filling_normal_Pa(20.0)),
    ]
    for other in ({"action_class": 1}, {"section": "plane"}, {"outlet_eccentricity_m": 2.5}, {"height_m": 3.0}):
        assert channels(replace(FAR, **other)) == []


@pytest.mark.parametrize("silo", [SILO, FAR, replace(SILO, section="plane"), replace(SILO, height_m=3.0)])
def test_the_envelope_is_over_all_cases(silo):
    columns, cases = depth_table(silo, 31, 0.02)
    for one in cases:
        for angle in np.arange(0.0, 360.0, 3.7):
            assert (one.normal_Pa(columns["depth_m"], angle) <= columns["envelope_normal_Pa"] * (1.0 + 1e-12)).all()
            assert (one.normal_Pa(columns["depth_m"], angle) >= columns["envelope_least_normal_Pa"] - 1e-6).all()
            assert (one.shear_Pa(columns["depth_m"], angle) <= columns["envelope_shear_Pa"] * (1.0 + 1e-12)).all()
    assert (columns["envelope_normal_Pa"] >= columns["p_he_Pa"]).all()


def test_a_patch_of_class_3_may_stand_anywhere():
    silo, s = replace(SILO, action_class=3), np.pi * 10.0 / 16.0
    columns, _ = depth_table(silo, 31, 0.02)
    factor, places = patches.discharge_factor(silo), np.linspace(0.5 * s, 30.0 - 0.5 * s, 50_000)
    for z, base, most, least in zip(
        columns["depth_m"], columns["p_he_Pa"], columns["envelope_normal_Pa"], columns["envelope_least_normal_Pa"],
        strict=True,
    ):  # fmt: skip
        over = factor * float(np.max(silo.discharge_normal_Pa(places[np.abs(places - z) <= 0.5 * s + 1e-9])))
        assert most == pytest.approx(base + over, rel=2e-4)
        assert least <= max(base - over * (1.0 - 2e-4), 0.0)  # no suction


@pytest.mark.parametrize("height", [30.0, 15.0, 8.0])
def test_pressure_and_friction_of_a_symmetrical_filling_belong_together(height):
    """Friction is mu times pressure, and carries with the vertical pressure below it the weight."""
    silo = replace(SILO, height_m=height)
    for one in load_cases(silo):
        if one.symmetrical and one.name in ("filling_pressure", "filling_friction"):
            load = {"filling_pressure": "wall pressure", "filling_friction": "wall friction"}[one.name]
            mu = silo.values(load).wall_friction
            z = np.linspace(0.0, height, 11)
            assert one.shear_Pa(z, 0.0) == pytest.approx(mu * one.normal_Pa(z, 0.0))
            places = [0.0, silo.surface_depth_m, height]
            down = sum(quad(lambda z, one=one: float(one.shear_Pa(z, 0.0)), *ends)[0] for ends in pairwise(places))
            below = float(silo.filling_vertical_Pa(height, load)) * silo.hydraulic_radius_m
            assert down + below == pytest.approx(9e3 * height * silo.hydraulic_radius_m, rel=1e-9)


@pytest.mark.parametrize("action_class", [2, 3])
@pytest.mark.parametrize("thickness", [0.01, 0.1, None])
def test_no_load_pulls_at_a_wall(action_class, thickness):
    """A solid carries no tension: least pressures are 0 at the surface, and nowhere below it.

    The heap is so far off that C_pe = 0.42 * 1 * 3 * 0.95 = 1.2: the patch alone is more than the pressure.
    """
    loose = replace(WHEAT, patch_factor=1.0)
    silo = replace(SILO, solid=loose, filling_eccentricity_m=5.0, outlet_eccentricity_m=3.0, action_class=action_class)
    columns, cases = depth_table(silo, 41, thickness)
    assert columns["envelope_least_normal_Pa"].min() == 0.0
    for one in cases:
        for angle in one.angles_deg:
            assert one.normal_Pa(columns["depth_m"], angle).min() >= 0.0, one.name


@pytest.mark.parametrize("height", [5.0, 9.0, 15.0, 30.0])
@pytest.mark.parametrize("action_class", [2, 3])
@pytest.mark.parametrize("name", solids())
def test_no_flow_channel_pulls_at_a_wall(name, action_class, height):
    """Beside a channel 2 p_hse - p_hce is below 0 near the surface of a squat silo, whose heap leaves the wall."""
    silo = replace(FAR, solid=solids()[name], height_m=height, action_class=action_class)
    columns, cases = depth_table(silo, 41, 0.02)
    assert columns["envelope_least_normal_Pa"].min() >= 0.0
    for one in cases:
        for angle in np.arange(0.0, 360.0, 7.3):
            assert one.normal_Pa(columns["depth_m"], angle).min() >= 0.0, one.name
            assert one.shear_Pa(columns["depth_m"], angle).min() >= 0.0, one.name
