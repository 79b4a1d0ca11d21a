"""Mass, mixed and funnel flow with known boundaries are found again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taichi_silo.analysis.measure.flow_pattern import flow_pattern, mean_velocity
from tests.made_up import down, lattice

WIDTH, HEIGHT, SPEED = 0.2, 0.5, 2e-3


def measured(points, speed, volume, **options):
    return flow_pattern(points, down(speed), volume, WIDTH, HEIGHT, SPEED, **options)


def channel(points, half_width_at):
    """Speed of a channel about the axis that carries the whole outflow, zero outside."""
    half = half_width_at(points[:, 1])
    return np.where(np.abs(points[:, 0] - 0.5 * WIDTH) < half, SPEED * 0.5 * WIDTH / half, 0.0)


def test_uniform_flow_is_mass_flow_also_between_walls_without_slip():
    points, volume, _ = lattice()
    found = measured(points, np.full(len(points), SPEED), volume)
    assert found.kind == "mass"
    assert found.transition_left_m == found.transition_right_m == found.stagnant_area_share == 0.0
    assert (found.x_left_m == 0.0).all() and (found.x_right_m == WIDTH).all()
    distance = np.minimum(points[:, 0], WIDTH - points[:, 0])
    assert measured(points, 1.05 * SPEED * (1.0 - np.exp(-distance / 0.005)), volume).kind == "mass"


@pytest.mark.parametrize("columns", [20, 40, 100], ids=["10 mm", "5 mm", "2 mm"])
def test_a_channel_that_meets_the_walls_is_mixed_flow(columns):
    """The boundary rises from 30 mm off the axis to the walls at a height of 0.28 m."""
    points, volume, spacing = lattice(columns)
    speed = channel(points, lambda y: 0.03 + 0.25 * y)
    found = measured(points, speed, volume)
    assert found.kind == "mixed"
    # where a tenth of the outflow's speed is the mean over the layer
    enters = 0.28 - 0.91 * max(0.01, 2.0 * spacing) / 0.25
    assert found.transition_left_m == pytest.approx(enters, abs=0.01)
    assert found.transition_right_m == pytest.approx(enters, abs=0.01)
    exact = 0.03 + 0.25 * found.height_m
    low = found.height_m < 0.24
    np.testing.assert_allclose(found.x_right_m[low], 0.1 + exact[low], atol=1.5 * spacing)
    np.testing.assert_allclose(found.x_left_m[low], 0.1 - exact[low], atol=1.5 * spacing)
    dead = 0.28 * (0.1 - 0.03) / (WIDTH * HEIGHT)  # two triangles
    assert found.stagnant_area_share == pytest.approx(dead, abs=0.1 * dead)


@pytest.mark.parametrize("columns", [20, 40, 100])
def test_a_step_in_height_is_placed_within_half_a_window(columns):
    points, volume, spacing = lattice(columns)
    found = measured(points, SPEED * (points[:, 1] > 0.2), volume)
    assert found.transition_left_m == pytest.approx(0.2, abs=0.5 * max(0.01, 2 * spacing) + 1e-9)
    assert found.stagnant_area_share == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize("columns", [20, 40, 100])
def test_a_pipe_is_funnel_flow(columns):
    points, volume, spacing = lattice(columns)
    found = measured(points, channel(points, lambda y: 0.04 + 0 * y), volume)
    assert found.kind == "funnel"
    assert np.isnan(found.transition_left_m) and np.isnan(found.transition_right_m)
    np.testing.assert_allclose(found.x_left_m, 0.06, atol=1.5 * spacing)
    np.testing.assert_allclose(found.x_right_m, 0.14, atol=1.5 * spacing)
    assert found.stagnant_area_share == pytest.approx(0.6, abs=0.02)


def test_what_moves_at_one_wall_or_only_at_the_surface():
    points, volume, _ = lattice()
    pipe = np.maximum(channel(points, lambda y: 0.04 + 0 * y), SPEED * (points[:, 1] > 0.47))
    assert measured(points, pipe, volume).kind == "funnel"  # sand that slides into a pipe makes no mixed flow
    found = measured(points, 2.0 * SPEED * (points[:, 0] > 0.1), volume)
    assert found.kind == "mixed"
    assert np.isnan(found.transition_left_m) and found.transition_right_m == 0.0
    sideways = flow_pattern(points, -down(np.zeros(len(points)))[:, ::-1] + [SPEED, 0.0], volume, WIDTH, HEIGHT, SPEED)
    assert sideways.stagnant_area_share == 0.0 and sideways.kind == "funnel"


def test_the_threshold_bounds_a_smooth_channel():
    points, volume, _ = lattice()
    speed = 1.5 * SPEED * np.exp(-(((points[:, 0] - 0.1) / 0.04) ** 2))
    for threshold in (0.05, 0.1, 0.3):
        found = measured(points, speed, volume, threshold=threshold)
        half = 0.04 * np.sqrt(np.log(1.5 / threshold))
        np.testing.assert_allclose(np.nanmedian(found.x_right_m), 0.1 + half, atol=0.001)


def test_mean_velocity_follows_the_points_that_stay():
    points, _, _ = lattice()
    number = np.arange(len(points)) + 7
    stay = points[:, 1] > 0.1
    order = np.random.default_rng(0).permutation(np.flatnonzero(stay))
    place, velocity, index = mean_velocity(points, (points - [0.0, 0.01])[order], 5.0, number, number[order])
    assert sorted(index) == sorted(np.flatnonzero(stay))
    assert velocity == pytest.approx(np.tile([0.0, -2e-3], (len(index), 1)))
    assert place == pytest.approx(points[index] - [0.0, 0.005])
    with pytest.raises(ValueError, match="interval"):
        mean_velocity(points, points, 0.0, number, number)


@pytest.mark.parametrize(
    ("words", "points", "volumes", "speed"),
    [("speed", 800, 800, 0.0), ("positions", 800, 799, SPEED), ("four", 3, 3, SPEED)],
)
def test_impossible_input_is_refused(words, points, volumes, speed):
    place, volume, _ = lattice(20)
    with pytest.raises(ValueError, match=words):
        flow_pattern(place[:points], 0 * place[:points], volume[:volumes], WIDTH, HEIGHT, speed)


@settings(deadline=None, max_examples=15)
@given(st.floats(-0.04, 0.04), st.floats(0.02, 0.05), st.floats(0.0, 0.5))
def test_the_mirrored_field_has_the_mirrored_pattern(offset, half, slope):
    points, volume, _ = lattice()
    inside = np.abs(points[:, 0] - 0.1 - offset) < half + slope * points[:, 1]
    found = measured(points, SPEED * inside, volume)
    mirrored = measured([WIDTH, 0.0] + points * [-1.0, 1.0], SPEED * inside, volume)
    assert mirrored.kind == found.kind
    assert mirrored.stagnant_area_share == pytest.approx(found.stagnant_area_share)
    assert mirrored.transition_left_m == pytest.approx(found.transition_right_m, abs=1e-6, nan_ok=True)
    assert mirrored.transition_right_m == pytest.approx(found.transition_left_m, abs=1e-6, nan_ok=True)
