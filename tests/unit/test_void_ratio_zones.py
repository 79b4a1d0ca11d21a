"""Shear zones of known thickness and number are found again."""

import numpy as np
import pytest

from taichi_silo.analysis.measure.void_ratio_zones import interior_zone_count, wall_zone_thickness_m

WIDTH, HEIGHT = 0.2, 0.5


def lattice(columns=40, rows=100, jitter=0.0):
    """Points (n, 2) of a regular fill, moved at random by a fraction of the spacing, and the spacing."""
    x, y = np.meshgrid((np.arange(columns) + 0.5) * WIDTH / columns, (np.arange(rows) + 0.5) * HEIGHT / rows)
    points = np.column_stack([x.ravel(), y.ravel()])
    spacing = WIDTH / columns
    return points + jitter * spacing * np.random.default_rng(3).uniform(-1, 1, points.shape), spacing


@pytest.mark.parametrize("columns, rows", [(40, 100), (80, 200), (16, 40)], ids=["5 mm", "2.5 mm", "12.5 mm"])
@pytest.mark.parametrize("thickness", [0.0125, 0.020, 0.031])
@pytest.mark.parametrize("change", [0.2, -0.06], ids=["dilatant", "contractant"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_thickness_of_a_wall_zone(columns, rows, thickness, change, side):
    points, spacing = lattice(columns, rows, jitter=0.2)
    distance = points[:, 0] if side == "left" else WIDTH - points[:, 0]
    void_ratio = 0.7 + change * (distance < thickness)
    zone = wall_zone_thickness_m(points, void_ratio, 0.7, WIDTH, side)
    assert zone.median_m == pytest.approx(thickness, abs=spacing)
    assert zone.lower_quartile_m <= zone.median_m <= zone.upper_quartile_m
    assert zone.contractant == (change < 0)
    assert len(zone.height_m) == len(zone.thickness_m) > 0


def test_half_width_of_a_smooth_zone_off_the_wall():
    points, spacing = lattice()
    x = points[:, 0]
    bell = np.exp(-np.log(2) * ((x - 0.008) / 0.010) ** 2)  # peak 8 mm off the wall, half of it 10 mm farther
    zone = wall_zone_thickness_m(points, 0.60 + 0.2 * bell, 0.60, WIDTH)
    assert zone.median_m == pytest.approx(0.018, abs=0.3 * spacing)


def test_thickness_may_vary_with_height():
    points, spacing = lattice()
    edge = 0.010 + 0.04 * points[:, 1]
    zone = wall_zone_thickness_m(points, 0.6 + 0.2 * (points[:, 0] < edge), 0.6, WIDTH)
    np.testing.assert_allclose(zone.thickness_m, 0.010 + 0.04 * zone.height_m, atol=spacing)
    assert zone.upper_quartile_m - zone.lower_quartile_m == pytest.approx(0.04 * 0.35 * HEIGHT, abs=spacing)


def test_uniform_loosening_is_not_part_of_the_zone():
    points, spacing = lattice()
    void_ratio = 0.6 + 0.15 + 0.1 * (points[:, 0] < 0.015)
    zone = wall_zone_thickness_m(points, void_ratio, np.full(len(points), 0.6), WIDTH)
    assert zone.median_m == pytest.approx(0.015, abs=spacing)


def test_no_zone_has_no_thickness_and_nothing_to_measure_is_nan():
    points, _ = lattice()
    noise = 0.002 * np.random.default_rng(0).standard_normal(len(points))
    zone = wall_zone_thickness_m(points, 0.65 + noise, 0.6, WIDTH)
    assert zone.median_m == zone.upper_quartile_m == 0.0
    assert not zone.contractant
    assert np.isnan(wall_zone_thickness_m(np.empty((0, 2)), np.empty(0), np.empty(0), WIDTH).median_m)
    assert interior_zone_count(np.empty((0, 2)), np.empty(0), WIDTH).count == 0
    with pytest.raises(ValueError, match="side"):
        wall_zone_thickness_m(points, np.ones(len(points)), 1.0, WIDTH, side="top")


def parabolic_zones(points, apexes, thickness=0.012, strength=0.15):
    """Void ratio with zones that rise from both walls to apexes on the axis."""
    arch = points[:, 1] + 6.0 * (points[:, 0] - 0.5 * WIDTH) ** 2
    return 0.62 + strength * sum(np.exp(-(((arch - apex) / (0.6 * thickness)) ** 2)) for apex in apexes)


@pytest.mark.parametrize(
    ("apexes", "lattice_of", "thickness"),
    [((0.20,), (40, 100), 0.012), ((0.10, 0.20, 0.36), (40, 100), 0.012), ((0.12, 0.28), (16, 40), 0.025)],
)
def test_zones_across_the_axis(apexes, lattice_of, thickness):
    points, spacing = lattice(*lattice_of, jitter=0.1)
    noise = 0.003 * np.random.default_rng(1).standard_normal(len(points))
    zones = interior_zone_count(points, parabolic_zones(points, apexes, thickness) + noise, WIDTH)
    assert zones.count == len(apexes)
    np.testing.assert_allclose(zones.height_m, apexes, atol=spacing)


def test_wall_zones_and_noise_do_not_cross_the_axis():
    points, _ = lattice()
    noise = 0.002 * np.random.default_rng(2).standard_normal(len(points))
    void_ratio = 0.6 + 0.2 * (np.abs(points[:, 0] - 0.1) > 0.085) + noise
    assert interior_zone_count(points, void_ratio, WIDTH).count == 0
    assert interior_zone_count(points, 0.9 - 0.05 * points[:, 1], WIDTH).count == 0


def test_much_weaker_zones_are_left_out_unless_asked_for():
    points, _ = lattice()
    void_ratio = parabolic_zones(points, (0.15,)) + parabolic_zones(points, (0.3,), strength=0.05) - 0.62
    assert interior_zone_count(points, void_ratio, WIDTH).count == 1
    assert interior_zone_count(points, void_ratio, WIDTH, threshold=0.2).count == 2
