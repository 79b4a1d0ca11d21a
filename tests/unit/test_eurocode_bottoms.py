"""EN 1991-4: floors and hoppers below vertical walls, and mass or funnel flow."""

from dataclasses import replace

import numpy as np
import pytest

from taichi_silo.analysis.theory.eurocode.bottoms import Bottom
from taichi_silo.analysis.theory.eurocode.flow_pattern import flow_pattern, largest_half_angle_deg
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.runs.eurocode import solids

CEMENT = EurocodeSilo(5.0, 12.0, solids()["cement"], "D2", hopper_height_m=8.0)


def limit_deg(silo, wall="D2"):
    """Half angle at which a hopper changes from steep to shallow: (1 - K) / (2 mu), both lower."""
    values = silo.solid.characteristic("hopper filling", wall, silo.action_class)
    return float(np.degrees(np.arctan((1.0 - values.pressure_ratio) / (2.0 * values.wall_friction))))


def test_steep_shallow_and_flat_by_hand():
    # K = 0.54 / 1.2 = 0.45, mu = 0.46 / 1.07 = 0.4299065: tan(beta) < 0.55 / 0.8598131 = 0.6396739, 32.606 degrees
    assert limit_deg(CEMENT) == pytest.approx(32.606, abs=1e-3)
    assert [Bottom(CEMENT, angle).kind for angle in (None, 20.0, 32.6, 32.61, 60.0, 85.0)] == [
        "flat", "steep", "steep", "shallow", "shallow", "flat",
    ]  # fmt: skip


@pytest.mark.parametrize("name", solids())
@pytest.mark.parametrize("state", ["filling"])
def test_a_hopper_goes_over_from_steep_to_shallow_without_a_jump(name, state):
    silo = replace(CEMENT, solid=solids()[name])
    limit = limit_deg(silo)
    steep, shallow = (Bottom(silo, limit + off, 0.5) for off in (-1e-7, 1e-7))
    assert (steep.kind, shallow.kind) == ("steep", "shallow")
    heights = np.linspace(0.2, 1.0, 5)
    pressures = [
        one.hopper(state).normal_stress_Pa(heights * one.hopper(state).transition_height_m) for one in (steep, shallow)
    ]
    assert pressures[0] == pytest.approx(pressures[1], rel=1e-6)


def test_a_shallow_hopper_is_discharged_as_it_was_filled():
    bottom = Bottom(CEMENT, 50.0, 0.5)
    for row in bottom.hopper_rows():
        assert row["filling_normal_Pa"] == row["discharge_normal_Pa"]


def test_the_hopper_begins_with_what_the_walls_let_down():
    bottom = Bottom(CEMENT, 20.0, 0.5)
    first = bottom.hopper_rows()[0]
    assert first["depth_m"] == 12.0
    assert first["filling_vertical_Pa"] == first["discharge_vertical_Pa"] == pytest.approx(bottom.transition_Pa)
    assert bottom.transition_Pa == pytest.approx(float(CEMENT.filling_vertical_Pa(12.0)))
    assert first["discharge_normal_Pa"] > first["filling_normal_Pa"]  # the switch


def test_a_frictionless_hopper_of_filling_is_a_fluid():
    """With mu to 0, F to 1 and n to 0: the vertical pressure grows by the weight, as in a fluid."""
    smooth = replace(CEMENT.solid, wall_friction_D2=1e-9)
    hopper = Bottom(replace(CEMENT, solid=smooth, height_m=4.0), 20.0, 0.5).hopper("filling")
    x = np.array([hopper.outlet_height_m, hopper.transition_height_m])
    fluid = hopper.transition_stress_Pa + 16e3 * (hopper.transition_height_m - x)
    assert hopper.normal_stress_Pa(x) == pytest.approx(fluid, rel=1e-6)


def test_the_bottom_load_is_magnified_by_class_and_solid():
    factors = [
        Bottom(replace(CEMENT, action_class=number), 20.0, dynamic=dynamic).load_factor
        for number in (1, 2, 3) for dynamic in (False, True)
    ]  # fmt: skip
    assert factors == [1.3, 1.6, 1.0, 1.2, 1.0, 1.2]


def test_the_floor_of_a_squat_silo_carries_the_heap_in_its_middle():
    floor = {ratio: Bottom(EurocodeSilo(10.0, 10.0 * ratio, solids()["sand"])) for ratio in (0.75, 2.0 - 1e-9, 2.0)}
    # h_c/d_c = 0.75: h_tp = 5 tan 39 = 4.0489202, h0 a third of it; delta = 16 * 2.6992801 = 43.188482 kPa
    # times (2 - 0.75) / (2 - 0.40489202) = 0.7836458
    more = floor[0.75].floor_Pa - floor[0.75].transition_Pa
    assert more == pytest.approx(43.188482e3 * 0.7836458, rel=1e-6)
    assert floor[2.0].floor_Pa == floor[2.0].transition_Pa
    # the increase ends at the slender limit, but the walls' own formula changes there from 5.3 to 5.2
    assert floor[2.0 - 1e-9].floor_Pa == pytest.approx(floor[2.0 - 1e-9].transition_Pa, rel=1e-8)


def test_a_floor_never_carries_more_than_the_fill_and_its_heap():
    for ratio in (0.2, 0.5, 1.0, 1.5, 3.0):
        for name in solids():
            bottom = Bottom(EurocodeSilo(10.0, 10.0 * ratio, solid=solids()[name]))
            weight = bottom.silo.solid.upper_weight_density_N_per_m3 * (10.0 * ratio + bottom.heap_m)
            assert 0.0 < bottom.floor_Pa <= weight


@pytest.mark.parametrize("section", ["round", "plane"])
@pytest.mark.parametrize("delta", [25.0, 30.0, 40.0, 50.0])
def test_rough_walls_need_steeper_hoppers_for_mass_flow_and_wedges_less_so(section, delta):
    limits = [largest_half_angle_deg(section, mu, delta) for mu in np.linspace(0.05, 0.45, 9)]
    assert (np.diff(limits) < 0.0).all()
    wedge, cone = (largest_half_angle_deg(one, 0.25, delta) for one in ("plane", "round"))
    assert wedge > cone


def test_a_hopper_has_mass_flow_where_all_values_say_so():
    wheat = EurocodeSilo(10.0, 30.0, solids()["wheat"], "D1", hopper_height_m=8.0)
    found = [flow_pattern(Bottom(wheat, angle, 1.0, "D1")) for angle in (10.0, 40.0, 60.0)]
    assert found == ["mass flow", "mass or funnel flow", "funnel flow"]
    assert flow_pattern(Bottom(wheat)) == "funnel flow"


def test_a_hopper_too_wide_for_walker_has_no_rows_but_a_reason():
    # phi_w = phi_i = 26: eps = 116; steep up to tan(beta) = 0.95 / (2 tan(26)), 44.3 degrees, passive up to 32
    own = replace(
        solids()["wheat"], internal_friction_angle_deg=26.0, internal_friction_factor=1.0, pressure_ratio=0.05,
        pressure_ratio_factor=1.0, wall_friction_D1=0.6,
    )  # fmt: skip
    wide = Bottom(replace(CEMENT, solid=own), 40.0, 0.5, "D1")
    assert wide.kind == "steep"
    with pytest.raises(ValueError, match="half_angle_deg must be under 32"):
        wide.hopper("discharge")
    assert Bottom(wide.silo, 31.0, 0.5, "D1").hopper("discharge").factor > 0.0
