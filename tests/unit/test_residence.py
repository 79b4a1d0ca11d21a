"""Residence times of flows whose streamlines are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taichi_silo.analysis.measure.residence import residence
from tests.made_up import down, lattice

WIDTH, HEIGHT, SPEED = 0.2, 0.5, 2e-3


@pytest.mark.parametrize("columns", [20, 40])
def test_plug_flow(columns):
    points, volume, _ = lattice(columns)
    found = residence(points, down(np.full(len(points), SPEED)), volume, WIDTH, WIDTH * SPEED)
    assert found.plug_time_s == pytest.approx(HEIGHT / SPEED)
    assert found.time_s == pytest.approx(points[:, 1] / SPEED)
    assert found.over_plug == pytest.approx(found.quantiles, abs=0.01)
    assert found.never_share == 0.0
    assert found.first_from_surface == pytest.approx(1.0, abs=2.0 * WIDTH / columns / HEIGHT)


def test_sand_that_is_in_the_outlet_takes_no_time():
    points, volume, _ = lattice(20)
    lower = points - [0.0, 1.5 * points[:, 1].min()]  # the lowest row is below the floor
    found = residence(lower, down(np.full(len(points), SPEED)), volume, WIDTH, WIDTH * SPEED)
    assert (found.time_s[lower[:, 1] < 0.0] == 0.0).all()
    assert found.time_s.min() == 0.0 and found.over_plug[0] > 0.0


@pytest.mark.parametrize("columns", [20, 40])
def test_a_shear_profile(columns):
    """Speed v0 (1/2 + x / w): every point sinks straight down at its own speed."""
    points, volume, _ = lattice(columns)
    speed = SPEED * (0.5 + points[:, 0] / WIDTH)
    found = residence(points, down(speed), volume, WIDTH, WIDTH * SPEED)
    # the raster ends half a cell from the walls, where it is constant
    inner = np.abs(points[:, 0] - 0.5 * WIDTH) < 0.4 * WIDTH
    np.testing.assert_allclose(found.time_s[inner], (points[:, 1] / speed)[inner], rtol=0.03)
    x, y = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(400) + 0.5) / 400)
    exact = np.quantile(y / (0.5 + x), found.quantiles)
    assert found.over_plug == pytest.approx(exact, abs=0.02)
    assert found.first_from_surface == pytest.approx(1.0 / 1.5, rel=0.05)


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_sand_beside_a_pipe_never_leaves(columns):
    points, volume, _ = lattice(columns)
    inside = np.abs(points[:, 0] - 0.1) < 0.04
    found = residence(points, down(2.5 * SPEED * inside), volume, WIDTH, WIDTH * SPEED)
    assert found.never_share == pytest.approx(0.6, abs=3.0 / columns)  # 1.5 spacings a side
    assert found.first_from_surface == pytest.approx(0.4, rel=0.06)


def test_streamlines_that_converge_on_an_outlet():
    """Velocity -c r / r^2 in a fan about the middle of the bottom: t = r^2 / (2 c)."""
    points, volume, _ = lattice(80)
    arm = points - [0.5 * WIDTH, -0.02]
    square = np.sum(arm**2, axis=1)
    strength = 1e-4
    found = residence(points, -strength * arm / square[:, None], volume, WIDTH, 2e-4, (0.05, 0.15))
    start = 0.02 / arm[:, 1]  # share of the way that is left below the bottom
    exact = square * (1.0 - start**2) / (2.0 * strength)
    inside = (np.abs(arm[:, 0]) < 1.8 * arm[:, 1]) & (square > 0.1**2) & (exact < found.plug_time_s * 20)
    np.testing.assert_allclose(found.time_s[inside], exact[inside], rtol=0.02)


def test_sand_that_stands_still_never_leaves_and_points_that_are_not_finite_have_no_time():
    points, volume, _ = lattice()
    found = residence(points, np.zeros_like(points), volume, WIDTH, WIDTH * SPEED)
    assert found.never_share == 1.0
    assert np.isnan(found.over_plug).all() and np.isinf(found.first_from_surface)
    points[3] = np.nan
    found = residence(points, down(np.full(len(points), SPEED)), volume, WIDTH, WIDTH * SPEED)
    assert np.isnan(found.time_s[3]) and np.isfinite(np.delete(found.time_s, 3)).all()


@pytest.mark.parametrize(
    ("words", "count", "outflow", "outlet"),
    [("positive", 50, 0.0, None), ("outlet", 50, 1.0, (0.1, 0.3)), ("four", 2, 1.0, None)],
)
def test_impossible_input_is_refused(words, count, outflow, outlet):
    points, volume, _ = lattice(10)
    with pytest.raises(ValueError, match=words):
        residence(points[:count], 0 * points[:count], volume[:count], WIDTH, outflow, outlet)


@settings(deadline=None, max_examples=8)
@given(st.floats(0.05, 0.15), st.floats(0.02, 0.05))
def test_the_mirrored_flow_has_the_same_times(middle, half):
    points, volume, _ = lattice(20)
    outlet = (middle - half, middle + half)
    arm = points - [middle, -half]
    velocity = -1e-4 * arm / np.sum(arm**2, axis=1)[:, None]
    found = residence(points, velocity, volume, WIDTH, 2e-4, outlet)
    other = residence(
        [WIDTH, 0.0] + points * [-1.0, 1.0], velocity * [-1.0, 1.0], volume, WIDTH, 2e-4,
        (WIDTH - outlet[1], WIDTH - outlet[0]),
    )  # fmt: skip
    assert other.over_plug == pytest.approx(found.over_plug, rel=1e-3)
    assert other.never_share == pytest.approx(found.never_share, abs=0.01)
