"""Criteria of the time step: exact for bodies whose answer is known, and what a run makes of the user's choice."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.shapes import SHAPES, Linear, UniformGimp
from taichi_silo.scene.method_options import MethodOptions
from validation.stability.bodies import block, change, solver
from validation.stability.step_criteria import Criteria
from validation.stability.time_step import Block

LANES = False  # many kernels, each compiled once; see conftest.py

CELL, DENSITY = 0.1, 1500.0
LAW = Elastic(1e6, 0.0)
SPEED = math.sqrt(1e6 / DENSITY)


def criteria(shape, place=(0.5, 0.5), velocity=lambda place: 0.0 * place, dt=1e-5):
    particles, grid = block(width=0.4, height=0.4, cell=CELL, origin=(0.3, 0.3), box=(1.0, 1.0), density=DENSITY)
    shift = (np.array(place) - 0.5) * CELL
    moved = particles.arrays()["position"] + shift
    change(particles, position=moved, velocity=velocity(moved))
    body = solver(particles, grid, shape, LAW)
    body.advance(1, dt)
    return Criteria(body).take(dt)


def test_the_steps_of_points_at_rest_in_the_middle_of_their_cells():
    found = criteria(UniformGimp(0.5))
    assert found["courant"] == pytest.approx(CELL / SPEED, rel=1e-6)
    # an axis: weights 1/2, 1/2 with slopes -1, 1 give 4; two axes give 8
    assert found["rigorous"] == pytest.approx(2.0 / math.sqrt(8.0) * CELL / SPEED, rel=1e-3)
    assert found["auto"] <= found["rigorous"] * (1 + 1e-6)


@pytest.mark.long
def test_the_velocity_step_is_a_cell_over_the_speed():
    found = criteria(UniformGimp(0.5), velocity=lambda place: np.tile([3.0, 4.0], (len(place), 1)))
    assert found["velocity"] == pytest.approx(CELL / 5.0)


@pytest.mark.long
def test_hat_functions_have_no_bound_next_to_a_node():
    steps = [criteria(Linear(), (edge, 0.5))["rigorous"] for edge in (0.5, 0.1, 0.01, 0.001)]
    assert steps == sorted(steps, reverse=True)
    assert steps[3] < 0.1 * steps[0]


@pytest.mark.long
def test_the_inversion_step_of_a_uniform_compression_is_the_inverse_of_its_rate():
    def closing(place):
        return np.stack([-8.0 * (place[:, 0] - 0.5), 0.0 * place[:, 0]], axis=1)

    assert 1.0 / criteria(UniformGimp(0.5), velocity=closing, dt=1e-9)["inversion"] == pytest.approx(8.0, rel=0.3)


def test_the_automatic_step_survives_and_twice_of_it_does_not():
    case = Block(UniformGimp(0.25), 2, sliver=False)
    auto = case.criteria()["auto"]
    assert case.survives(auto)
    assert not case.survives(2.0 * auto)


@pytest.mark.long
@pytest.mark.parametrize("name", SHAPES)
def test_the_rigorous_step_is_stable_for_every_shape(name):
    """Domains of four points a cell end on grid lines at first: weights next to zero must not lose their digits."""
    case = Block(SHAPES[name](0.25), 2, sliver=False)
    assert case.survives(0.99 * case.criteria()["rigorous"])


@pytest.mark.long
def test_nearly_empty_cells_break_hat_functions_and_not_gimp():
    """The surface reaches a thousandth of a cell into the next one, whose nodes then hold next to no mass."""
    for shape, stable in ((Linear(0.25), False), (UniformGimp(0.25), True)):
        case = Block(shape, 2, sliver=True)
        assert case.survives(0.9 * case.criteria()["auto"]) is stable
    case = Block(Linear(0.25), 2, sliver=True)
    assert case.survives(0.95 * case.criteria()["rigorous"])  # the bound at the points as they lie knows it


def test_a_user_may_choose_the_step_in_two_ways():
    found = SimpleNamespace(stable_step=2.0, transit=4.0)
    assert MethodOptions().time_step(found, 0.9) == pytest.approx(1.8)
    assert MethodOptions(cfl=0.3).time_step(found, 0.9) == pytest.approx(1.2)
    assert MethodOptions(time_step_s=0.5).time_step(found, 0.9) == 0.5
    with pytest.raises(ValueError, match="cannot be given together"):
        MethodOptions(cfl=0.3, time_step_s=0.5)
