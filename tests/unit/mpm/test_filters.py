"""Filters of stresses: one is a projection, the other is not."""

import numpy as np
import pytest

from taichi_silo.mpm.filters import NullSpace, Smoothing
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.shapes import Linear, UniformGimp
from validation.stability.bodies import block, change, solver
from validation.stability.null_space import checkerboard_left, null_part, wave_left

CELL = 0.1


class Filtered:
    """A block whose points are scattered a little, with a stress, and what a filter makes of it."""

    def __init__(self, kind, per_axis, stress, jitter=0.2):
        law = Elastic(1e6, 0.0)
        self.particles, self.grid = block(width=0.4, height=0.4, cell=CELL, points_per_axis=per_axis)
        place = self.particles.arrays()["position"]
        rng = np.random.default_rng(5)
        d = CELL / per_axis
        self.place = place + jitter * d * rng.uniform(-1, 1, place.shape)
        self.volume = d * d * rng.uniform(0.8, 1.2, len(place))
        change(self.particles, position=self.place, volume=self.volume, stress=stress(self.place, rng))
        self.body = solver(self.particles, self.grid, Linear(), law, filtering=kind)
        self.before = self.particles.arrays()["stress"]
        self.once = self.apply()

    def apply(self):
        """One step of no length: motion and law change nothing, the filter acts."""
        velocity = np.zeros_like(self.place)
        change(self.particles, velocity=velocity)
        self.body.advance(1, 0.0)
        return self.particles.arrays()["stress"]

    def nodal_forces(self, stress):
        """Internal forces of hat functions, by a loop in Python."""
        force = np.zeros((7, 7, 2))
        for (x, y), V, (xx, yy, _, xy) in zip(self.place / CELL, self.volume, stress, strict=True):
            i, j = int(x), int(y)
            a, b = x - i, y - j
            for m, n, gx, gy in ((0, 0, b - 1, a - 1), (1, 0, 1 - b, -a), (0, 1, -b, 1 - a), (1, 1, b, a)):
                force[i + m, j + n] -= V / CELL * np.array([xx * gx + xy * gy, xy * gx + yy * gy])
        return force


def rough(place, rng):
    return rng.normal(0.0, 1e3, (len(place), 4))


def linear(place, rng):
    return np.stack([1e3 * place[:, 0], 2e3 * place[:, 1] - 1e3, 0 * place[:, 0], 500 * place.sum(axis=1)], axis=1)


@pytest.mark.parametrize("per_axis", [2, 3])
def test_the_null_space_filter_is_a_projection_that_changes_no_nodal_force_of_hat_functions(per_axis):
    case = Filtered(NullSpace, per_axis, rough)
    before, after = case.nodal_forces(case.before), case.nodal_forces(case.once)
    assert np.abs(after - before).max() < 1e-12 * np.abs(before).max() + 1e-10
    assert np.abs(null_part(case.place, case.volume, case.once, CELL)).max() < 1e-9
    assert np.abs(case.once - case.before).max() > 100.0
    assert np.abs(case.apply() - case.once).max() < 1e-9


@pytest.mark.parametrize(("per_axis", "stress"), [(2, linear), (3, linear), (1, rough)])
def test_it_keeps_linear_stresses_and_what_is_alone_in_its_cell(per_axis, stress):
    case = Filtered(NullSpace, per_axis, stress)
    assert np.abs(case.once - case.before).max() < 1e-9


def test_smoothing_is_no_projection_and_spreads_stress_with_one_point_a_cell():
    case = Filtered(Smoothing, 1, rough, jitter=0.0)
    assert np.abs(case.apply() - case.once).max() > 10.0


def test_a_checkerboard_stays_for_ever_and_the_filter_removes_it():
    shape = UniformGimp(0.25)
    assert checkerboard_left(shape, 2, None, 200) == pytest.approx(1.0, abs=1e-3)
    assert checkerboard_left(shape, 2, NullSpace, 200) < 1e-12


def test_the_filter_leaves_a_stress_at_rest_alone_and_smoothing_does_not():
    shape = UniformGimp(0.25)
    assert wave_left(shape, 2, NullSpace, 200) == pytest.approx(1.0, abs=1e-3)
    assert wave_left(shape, 2, Smoothing, 200) < 0.1
