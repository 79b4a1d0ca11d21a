"""Channel of flow at a wall, EN 1991-4, 5.2.4: a published angle, geometry by other means, balance of the pressures."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taichi_silo.analysis.theory.flow_channel import SIZE_RATIOS, FlowChannel

# silo of wheat of 10 m, published: theta_c = 22.3 deg for r_c = 0.6 r (Studia Geotechnica et Mechanica 40, 2018,
# doi 10.2478/sgem-2018-0043), with mu = 0.491 (lower), phi_i = 33.6 deg (upper), K = 0.599, gamma = 9 kN/m3
WHEAT = FlowChannel(5.0, 0.6, 9e3, 0.491, 0.599, 33.6)

channels = st.builds(
    FlowChannel,
    radius_m=st.floats(0.5, 20.0),
    size_ratio=st.floats(0.05, 0.9),
    weight_density_N_per_m3=st.just(1e4),
    wall_friction=st.floats(0.05, 0.5),
    pressure_ratio=st.floats(0.3, 0.8),
    internal_friction_angle_deg=st.floats(27.0, 45.0),
)


def test_published_contact():
    # eta = 0.491 / 0.664398 = 0.739014; e_c / r = 0.739014 * 0.4 + 0.260986 * 0.6324555 = 0.460668
    # cos(theta_c) = (1 + 0.212215 - 0.36) / 0.921336 = 0.924978: 22.33 deg
    assert WHEAT.eccentricity_m == pytest.approx(5.0 * 0.460668, rel=1e-5)
    assert WHEAT.contact_angle_deg == pytest.approx(22.3, abs=0.05)


@given(channels)
def test_edge_of_the_contact_lies_on_wall_and_channel(channel):
    theta, psi = np.radians(channel.contact_angle_deg), np.radians(channel.channel_angle_deg)
    across = channel.channel_radius_m * np.sin(psi)  # (5.59)
    along = channel.eccentricity_m + channel.channel_radius_m * np.cos(psi)
    assert across == pytest.approx(channel.radius_m * np.sin(theta), abs=1e-7 * channel.radius_m)
    assert along == pytest.approx(channel.radius_m * np.cos(theta), abs=1e-7 * channel.radius_m)


@given(channels)
def test_area_is_that_common_to_two_circles(channel):
    r, r_c, e = channel.radius_m, channel.channel_radius_m, channel.eccentricity_m
    x = (e**2 + r**2 - r_c**2) / (2.0 * e)  # of the chord, from the silo's axis
    caps = r**2 * np.arccos(x / r) - x * np.sqrt(r**2 - x**2)
    d = e - x
    caps += r_c**2 * np.arccos(d / r_c) - d * np.sqrt(max(r_c**2 - d**2, 0.0))
    assert channel.area_m2 == pytest.approx(caps, rel=1e-6)


@given(channels, st.floats(0.1, 50.0))
def test_mean_over_the_circumference_is_the_pressure_of_filling(channel, depth):
    theta = channel.contact_angle_deg
    share = theta / 180.0
    total = share * channel.channel_normal_Pa(depth) + share * channel.adjacent_normal_Pa(depth)
    total += (1.0 - 2.0 * share) * channel.static_normal_Pa(depth)
    assert total == pytest.approx(float(channel.static_normal_Pa(depth)), rel=1e-12)
    assert 2.0 * theta < 180.0


@given(channels)
def test_pressures_begin_hydrostatic_and_saturate(channel):
    start = channel.pressure_ratio * 1e4 * 1e-6
    for pressure in (channel.static_normal_Pa, channel.channel_normal_Pa):
        assert pressure(1e-6) == pytest.approx(start, rel=1e-4)
    deep = 1e3 * channel.radius_m
    weight = 1e4 * channel.area_m2  # per metre of depth, on friction of wall and fill
    friction = channel.wall_perimeter_m * channel.wall_friction
    friction += channel.fill_perimeter_m * np.tan(np.radians(channel.internal_friction_angle_deg))
    assert channel.channel_normal_Pa(deep) * friction == pytest.approx(weight, rel=1e-9)


def test_pressure_is_low_in_the_channel_and_high_beside_it():
    for ratio in SIZE_RATIOS:
        channel = replace(WHEAT, size_ratio=ratio)
        theta = channel.contact_angle_deg
        low, high, far, mirrored = channel.wall_normal_Pa(20.0, np.array([0.0, 1.5 * theta, 3.0 * theta, -1.5 * theta]))
        assert low < far < high and high == mirrored
        assert low + high == pytest.approx(2.0 * far)


def test_a_wall_as_rough_as_the_fill_is_only_touched():
    rough = replace(WHEAT, wall_friction=float(np.tan(np.radians(33.6))))
    assert rough.contact_angle_deg == pytest.approx(0.0, abs=1e-5)
    assert rough.area_m2 == pytest.approx(np.pi * 9.0, rel=1e-6)


@pytest.mark.parametrize(
    "wrong",
    [
        {"radius_m": 0.0}, {"size_ratio": 1.0}, {"wall_friction": 0.7}, {"pressure_ratio": -1.0},
        {"internal_friction_angle_deg": 90.0},
    ],
)  # fmt: skip
def test_impossible_channels_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        replace(WHEAT, **wrong)


def test_places_off_the_wall_are_refused():
    with pytest.raises(ValueError, match="depth_m"):
        WHEAT.channel_normal_Pa(-1.0)
    with pytest.raises(ValueError, match="angle_deg"):
        WHEAT.wall_normal_Pa(1.0, 181.0)
