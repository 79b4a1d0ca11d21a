"""A pressure cell averages."""

import numpy as np
import pytest

from taichi_silo.analysis.measure.wall_pressure import cell_mean

HEIGHT = np.arange(0.0, 0.5001, 0.005)


def test_a_linear_stress_is_read_as_it_is_away_from_the_ends():
    stress = 3000.0 - 5000.0 * HEIGHT
    assert cell_mean(HEIGHT, stress)[2:-2] == pytest.approx(stress[2:-2])


def test_a_stress_that_alternates_from_node_to_node_averages_out():
    stress = 1000.0 + 500.0 * (-1.0) ** np.arange(len(HEIGHT))
    assert cell_mean(HEIGHT, stress)[2:-2] == pytest.approx(1000.0)


def test_the_force_is_kept():
    stress = np.exp(-(((HEIGHT - 0.25) / 0.05) ** 2))
    assert np.trapezoid(cell_mean(HEIGHT, stress), HEIGHT) == pytest.approx(np.trapezoid(stress, HEIGHT), rel=1e-6)
