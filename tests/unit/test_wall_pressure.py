"""A pressure cell averages."""

import numpy as np
import pytest

from taichi_silo.analysis.measure.wall_pressure import CELL_M, CORNER_M, HOPPER_CELL_M, Reading, cell_mean

HEIGHT = np.arange(0.0, 0.5001, 0.005)


def test_a_linear_stress_is_read_as_it_is_away_from_the_ends():
    stress = 3000.0 - 5000.0 * HEIGHT
    assert cell_mean(HEIGHT, stress, CELL_M)[2:-2] == pytest.approx(stress[2:-2])


def test_a_stress_that_alternates_from_node_to_node_averages_out():
    stress = 1000.0 + 500.0 * (-1.0) ** np.arange(len(HEIGHT))
    assert cell_mean(HEIGHT, stress, CELL_M)[2:-2] == pytest.approx(1000.0)


def test_the_force_is_kept():
    stress = np.exp(-(((HEIGHT - 0.25) / 0.05) ** 2))
    assert np.trapezoid(cell_mean(HEIGHT, stress, CELL_M), HEIGHT) == pytest.approx(
        np.trapezoid(stress, HEIGHT), rel=1e-6
    )


@pytest.mark.parametrize("height", [0.04, 0.3, 0.5, 2.5])
def test_in_a_silo_of_0_2_m_stresses_are_read_over_the_lengths_of_the_model_silo(height):
    assert Reading.of(0.2, height) == Reading() == Reading(CELL_M, HOPPER_CELL_M, CORNER_M)


@pytest.mark.parametrize(("width", "height", "size"), [(6.0, 20.0, 30.0), (0.1, 0.5, 0.5), (40.0, 5.0, 25.0)])
def test_they_grow_with_the_silo(width, height, size):
    """A cell of 20 mm in a silo of 6 m lies within one cell of any grid that can be paid for: it would read nodes."""
    reading = Reading.of(width, height)
    assert (reading.cell_m, reading.hopper_cell_m, reading.corner_m) == pytest.approx(
        (0.02 * size, 0.05 * size, 0.0125 * size)
    )


def test_a_profile_and_its_enlargement_are_read_alike():
    stress = np.exp(-(((HEIGHT - 0.25) / 0.02) ** 2))
    small, large = Reading.of(0.2, 0.5), Reading.of(6.0, 15.0)
    assert cell_mean(30.0 * HEIGHT, stress, large.cell_m) == pytest.approx(cell_mean(HEIGHT, stress, small.cell_m))
