"""A sheared layer becomes the one-dimensional solution as the cells shrink, with one point a cell and with four.

`tests/data/layer` says how that solution was found; in two dimensions nothing but the height is special.
"""

import numpy as np
import pandas as pd
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.scene.method_options import MethodOptions
from validation.layer import layer, sheared
from validation.layer_study import CASES


def curve(case, cells, points, until_mm, means=None, wall="ignored", **options):
    """Displacements [m] and shear stresses [Pa], the layer at the end, and the reference's shear stresses."""
    runtime.init()
    piece = layer(*CASES[case], cells, points, MethodOptions(**options), wall=wall, means=means)
    u, tau, _height = np.array(list(sheared(piece, 1e-3 * until_mm))).T
    return u, tau, piece


def errors(data, case, u, tau, at_mm):
    """Relative errors of the shear stress at some displacements."""
    found = pd.read_csv(data / "layer" / f"{case}.csv", comment="#")
    at = 1e-3 * np.array(at_mm)
    return np.interp(at, u, tau) / np.interp(at, found.displacement_m, found.shear_stress_Pa) - 1.0


LONG = pytest.mark.long


@pytest.mark.parametrize(
    ("case", "points"),
    [("a", 1), ("d_short", 1), *(pytest.param(case, points, marks=LONG) for case in CASES for points in (1, 4))],
)
def test_on_cells_as_wide_as_the_length_the_shear_stress_is_right_to_one_per_cent(data, case, points):
    u, tau, piece = curve(case, 1, points, 4)
    assert np.abs(errors(data, case, u, tau, [1, 2, 4])).max() < 0.01
    assert -piece.particles.arrays()["stress"][:, 1].max() > 0.8 * CASES[case][0]  # every point carries its share


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("points", [1, 4])
def test_on_cells_of_half_the_length_it_is_right_to_three_thousandths(data, case, points):
    u, tau, piece = curve(case, 2, points, 4)
    assert np.abs(errors(data, case, u, tau, [1, 2, 4])).max() < 0.003
    assert -piece.particles.arrays()["stress"][:, :3].max() > 5.0


def test_a_wall_that_counts_as_rigid_moves_the_zone_into_the_sand(data):
    """The shear stress is that of the solution whose kernel reaches into the wall, 3 % above the other."""
    runtime.init()
    u, tau, _height = np.array(list(sheared(layer(*CASES["a"], 1, 1, wall="rigid"), 1e-3))).T
    assert np.abs(errors(data, "a_wall_counts", u, tau, [0.5, 1])).max() < 0.01
    assert errors(data, "a", u, tau, [1])[0] > 0.015


@pytest.mark.parametrize("wall", ["ignored", pytest.param("rigid", marks=pytest.mark.long)])
def test_means_by_the_grid_shear_the_layer_as_those_over_rows_to_a_thousandth(wall):
    u, tau, _ = curve("a", 2, 1, 1, "rows", wall)
    _, by_grid, _ = curve("a", 2, 1, 1, "grid", wall)
    later = u > 1e-4
    assert np.abs(by_grid[later] / tau[later] - 1.0).max() < 1e-3


@pytest.mark.long
def test_without_the_filter_points_of_a_cell_part_until_half_of_them_carry_nothing(data):
    u, tau, piece = curve("a", 1, 4, 4, stress_filter="none")
    assert errors(data, "a", u, tau, [4])[0] > 0.1
    assert -piece.particles.arrays()["stress"][:, 1].max() < 5.0


@pytest.mark.long
def test_half_the_time_step_gives_the_same():
    _, tau, _ = curve("a", 1, 4, 1)
    _, halved, _ = curve("a", 1, 4, 1, cfl=0.2)
    assert halved[-1] == pytest.approx(tau[-1], rel=1e-3)
