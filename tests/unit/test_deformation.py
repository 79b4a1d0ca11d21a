"""Net shear is what a column that only settles does not have."""

import numpy as np
import pytest

from taichi_silo.analysis.measure import deformation
from taichi_silo.analysis.measure.deformation import Rings

X, Y = np.meshgrid(np.arange(20) * 0.005, np.arange(30) * 0.005)
BEFORE = np.stack([X.ravel(), Y.ravel()], axis=1)


@pytest.mark.parametrize("settlement", [0.002, 0.03])
def test_uniform_settlement_is_no_shear(settlement):
    """Ratcheting compacts vertically; 0.03 is a fall of the void ratio from 0.600 to 0.552."""
    assert Rings(BEFORE).net_shear(BEFORE * [1.0, 1.0 - settlement]).max() < 1e-12


def test_simple_shear_is_found_with_its_size():
    gamma = 0.01
    sheared = BEFORE + np.stack([0 * X.ravel(), gamma * X.ravel()], axis=1)
    assert Rings(BEFORE).net_shear(sheared) == pytest.approx(gamma / np.sqrt(2.0), rel=1e-2)


def test_a_rigid_rotation_is_no_shear():
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    assert Rings(BEFORE).net_shear(BEFORE @ turn.T).max() < 1e-12


def test_sand_that_is_drawn_out_upwards_is_not_taken_for_settled_sand():
    assert Rings(BEFORE).net_shear(BEFORE * [1.0, 1.01]) == pytest.approx(0.01, rel=0.01)


def test_points_that_are_looked_at_in_parts_have_the_same_strains(monkeypatch):
    sheared = BEFORE + 1e-2 * np.sin(30.0 * BEFORE[:, ::-1])
    whole = Rings(BEFORE).net_shear(sheared)
    monkeypatch.setattr(deformation, "AT_ONCE", 7)
    assert np.array_equal(Rings(BEFORE).net_shear(sheared), whole)
