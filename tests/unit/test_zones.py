"""Shear zones of known thickness, inclination, curvature and branching are found again, whatever the spacing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taichi_silo.analysis.measure.ridges import thin
from taichi_silo.analysis.measure.zone import _side, circle_curvature, parabola_curvature
from taichi_silo.analysis.measure.zones import shear_zones
from tests.made_up import lattice

WIDTH, HEIGHT = 0.2, 0.5
SPACINGS = pytest.mark.parametrize("columns", [20, 40, 60], ids=["10 mm", "5 mm", "3.3 mm"])


def fill(columns=40):
    """Points (n, 2) and their spacing."""
    return lattice(columns, seed=3)[::2]


def bell(distance, thickness):
    """1 on the middle, 1/2 half a thickness off."""
    return np.exp(-4.0 * np.log(2.0) * (distance / thickness) ** 2)


def straight(points, degrees, through=(0.1, 0.25)):
    """Distance from a straight line."""
    angle = np.radians(degrees)
    return (points - through) @ [-np.sin(angle), np.cos(angle)]


def arms(points, centre, tips):
    """Distance from the nearest of several pieces of straight lines from a centre to the tips."""
    way = np.asarray(tips) - centre
    share = np.clip((points - centre) @ way.T / np.sum(way**2, axis=1), 0.0, 1.0)
    return np.hypot(*(points[:, None] - centre - share[..., None] * way).transpose(2, 0, 1)).min(axis=1)


@SPACINGS
@pytest.mark.parametrize("degrees, thickness", [(55.0, 0.03), (-50.0, 0.03), (5.0, 0.04), (88.0, 0.03)])
def test_a_straight_band(columns, degrees, thickness):
    points, spacing = fill(columns)
    noise = 0.02 * np.random.default_rng(1).standard_normal(len(points))
    found = shear_zones(points, 0.1 + bell(straight(points, degrees), thickness) + noise, WIDTH)
    assert found.count == len(found.zones) == 1
    zone = found.zones[0]
    # the bell of the sampling adds its square to that of the band
    assert zone.thickness_m.median == pytest.approx(np.hypot(thickness, 1.06 * spacing), abs=0.25 * spacing)
    assert zone.inclination_deg.median == pytest.approx(degrees, abs=3.0)
    assert abs(zone.curvature_1_per_m) < 8.0 * spacing / zone.length_m**2
    assert zone.strain.median == pytest.approx(1.0, abs=0.15)
    assert not len(found.branching_m) and not len(found.wall_branching_m)
    assert found.spacing_m == pytest.approx(spacing, rel=0.05)


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_a_band_narrower_than_the_points_reads_one_to_two_spacings_and_over_lengths_of_the_sand(columns):
    points, spacing = fill(columns)
    narrow = 1.0 * (np.abs(straight(points, 55.0)) < 0.6 * spacing)
    zone = shear_zones(points, narrow, WIDTH, d50_m=5e-4, internal_length_m=1.5e-3).zones[0]
    assert spacing < zone.thickness_m.median < 2.0 * spacing
    assert zone.thickness_over_d50 == pytest.approx(zone.thickness_m.median / 5e-4)
    assert zone.thickness_over_internal_length == pytest.approx(zone.thickness_m.median / 1.5e-3)
    assert np.isnan(shear_zones(points, narrow, WIDTH).zones[0].thickness_over_d50)


@SPACINGS
@pytest.mark.parametrize("bend", [-6.0, 4.0])
def test_a_parabola(columns, bend):
    """The line y = 0.25 + b (x - w/2)^2 has the curvature 2 b at its apex."""
    points, spacing = fill(columns)
    x = points[:, 0] - 0.5 * WIDTH
    distance = (points[:, 1] - 0.25 - bend * x**2) / np.sqrt(1.0 + (2.0 * bend * x) ** 2)
    found = shear_zones(points, bell(distance, 0.03), WIDTH)
    assert found.count == len(found.zones) == 1
    zone = found.zones[0]
    assert zone.apex_curvature_1_per_m == pytest.approx(2.0 * bend, rel=0.06)
    assert zone.curvature_1_per_m == pytest.approx(2.0 * bend, rel=0.25)  # a circle, of less curvature than the apex
    assert abs(zone.inclination_deg.median) < 6.0
    meets = 0.25 + bend * 0.25 * WIDTH**2
    assert [zone.wall_left_m, zone.wall_right_m] == pytest.approx([meets, meets], abs=0.02)  # prolonged straight on


@SPACINGS
def test_a_circle(columns):
    points, _ = fill(columns)
    found = shear_zones(points, bell(np.hypot(points[:, 0] - 0.02, points[:, 1] - 0.2) - 0.1, 0.03), WIDTH)
    assert found.zones[0].curvature_1_per_m == pytest.approx(-10.0, rel=0.05) or found.zones[0].curvature_1_per_m > 0
    assert abs(found.zones[0].curvature_1_per_m) == pytest.approx(10.0, rel=0.05)


@SPACINGS
@pytest.mark.parametrize("thickness", [0.02, 0.03])
def test_a_branching_zone(columns, thickness):
    points, spacing = fill(columns)
    distance = arms(points, np.array([0.1, 0.25]), [(0.1, 0.0), (0.0, 0.42), (0.2, 0.42)])
    found = shear_zones(points, 0.02 + bell(distance, thickness), WIDTH)
    assert (found.count, len(found.zones)) == (1, 3)
    assert found.branching_m == pytest.approx(np.array([[0.1, 0.25]]), abs=0.5 * thickness + spacing)
    steep = np.degrees(np.arctan2(0.17, 0.1))
    angles = sorted(abs(zone.inclination_deg.median) for zone in found.zones)
    assert angles == pytest.approx([steep, steep, 90.0], abs=3.0)
    walls = [(zone.wall_left_m, zone.wall_right_m) for zone in found.zones]
    assert np.isfinite(walls).sum() == 2 and np.nansum(walls) == pytest.approx(0.84, abs=4.0 * spacing)


@SPACINGS
def test_zones_that_cross_or_meet_at_a_wall(columns):
    points, spacing = fill(columns)
    crossing = np.maximum(bell(straight(points, 55.0), 0.025), bell(straight(points, -55.0), 0.025))
    found = shear_zones(points, crossing, WIDTH)
    assert (found.count, len(found.zones)) == (1, 4)
    assert found.branching_m == pytest.approx(np.array([[0.1, 0.25]]), abs=spacing)
    found = shear_zones(points, bell(arms(points, np.array([0.0, 0.25]), [(0.2, 0.05), (0.2, 0.4)]), 0.025), WIDTH)
    assert len(found.zones) == 2
    assert found.wall_branching_m == pytest.approx(np.array([[0.0, 0.25]]), abs=spacing)


@SPACINGS
def test_two_zones_and_what_they_do_to_the_volume(columns):
    points, _ = fill(columns)
    low, high = (bell(straight(points, 20.0, (0.1, height)), 0.025) for height in (0.15, 0.35))
    found = shear_zones(points, 0.1 + low + 0.7 * high, WIDTH, void_ratio_change=0.03 + 0.1 * low - 0.05 * high)
    assert found.count == 2
    kinds = {round(float(zone.middle_m[:, 1].mean()), 1): zone.kind for zone in found.zones}
    assert sorted(kind for _, kind in sorted(kinds.items())) == ["contractant", "dilatant"]
    strongest = max(found.zones, key=lambda zone: zone.strain.median)
    assert strongest.kind == "dilatant" and strongest.void_ratio_change == pytest.approx(0.08, abs=0.02)
    assert {zone.kind for zone in shear_zones(points, low, WIDTH).zones} == {"unknown"}
    assert {zone.kind for zone in shear_zones(points, low, WIDTH, 0.0 * low).zones} == {"neutral"}


@pytest.mark.parametrize(
    "strain",
    [
        lambda x, y, noise: 0.1 + 0.01 * noise, lambda x, y, noise: 0.0 * x,
        lambda x, y, noise: 0.1 + y,  # strain that grows evenly
        lambda x, y, noise: bell(x, 0.02),  # along a wall: another measure's
    ],
)  # fmt: skip
def test_no_zone(strain):
    points, _ = fill()
    noise = np.random.default_rng(0).standard_normal(len(points))
    assert shear_zones(points, strain(*points.T, noise), WIDTH).count == 0


@pytest.mark.parametrize(("words", "points", "strains", "width"), [
    ("width", 800, 800, 0.0), ("25", 10, 10, WIDTH), ("positions", 800, 799, WIDTH),
])  # fmt: skip
def test_impossible_input_is_refused(words, points, strains, width):
    place, _ = fill(20)
    with pytest.raises(ValueError, match=words):
        shear_zones(place[:points], place[:strains, 0], width)


def test_curvatures_of_exact_lines():
    angle = np.linspace(0.3, 1.2, 30)
    arc = 0.2 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert circle_curvature(arc) == pytest.approx(-5.0)
    assert circle_curvature(-arc) == pytest.approx(5.0)
    t = np.linspace(-0.1, 0.1, 31)
    assert circle_curvature(np.column_stack([t, 0.7 * t])) == pytest.approx(0.0, abs=1e-9)
    assert parabola_curvature(np.column_stack([t, 3.0 * t**2])) == pytest.approx(6.0)


def test_lines_of_two_cells_stay_lines_when_they_are_thinned():
    for direction in ((0, 1), (1, 0), (1, 1), (1, -1)):
        mask = np.zeros((40, 40), bool)
        for k in range(-12, 13):
            r, c = 20 + k * direction[0], 20 + k * direction[1]
            mask[r : r + 2, c : c + 2] = True
        assert 23 <= thin(mask).sum() <= 28


@settings(deadline=None, max_examples=8)
@given(st.floats(25.0, 65.0), st.floats(0.02, 0.035), st.floats(0.2, 0.3))
def test_the_mirrored_field_has_the_mirrored_zone(degrees, thickness, height):
    points, spacing = fill(24)
    strain = bell(straight(points, degrees, (0.1, height)), thickness)
    (zone,) = shear_zones(points, strain, WIDTH).zones
    (other,) = shear_zones([WIDTH, 0.0] + points * [-1.0, 1.0], strain, WIDTH).zones
    assert other.inclination_deg.median == pytest.approx(-zone.inclination_deg.median, abs=3.0)
    assert other.thickness_m.median == pytest.approx(zone.thickness_m.median, abs=0.2 * spacing)
    assert other.wall_left_m == pytest.approx(zone.wall_right_m, abs=spacing, nan_ok=True)
    assert other.wall_right_m == pytest.approx(zone.wall_left_m, abs=spacing, nan_ok=True)


def test_a_profile_that_is_nowhere_above_half_has_no_width():
    distance = np.array([0.0, 1.0, 2.0])
    assert np.isnan(_side(np.array([-1.0, -2.0, -3.0]), distance))  # nothing was sheared: half of it is more than it
    assert np.isnan(_side(np.array([0.0, 0.0, 0.0]), distance))
    assert _side(np.array([2.0, 1.5, 0.5]), distance) == pytest.approx(1.5)
