"""Fields of the points of a whole silo, asked for one by one or in pieces, are those that are asked for together."""

import numpy as np
import pytest

from taichi_silo.scene.silo import Silo
from taichi_silo.simulation import views
from taichi_silo.simulation.simulation import Simulation
from tests.smallest import SMALLEST, smallest

SILOS = {
    "whole": SMALLEST.silo.model_copy(update={"half": "no"}),
    "half": SMALLEST.silo.model_copy(update={"half": "yes"}),
    "round": Silo(width_m=0.2, height_m=0.4, section="round"),
}


@pytest.mark.parametrize("silo", SILOS.values(), ids=SILOS)
def test_a_field_in_pieces_is_the_field(silo, monkeypatch):
    scene = smallest(silo=silo)
    scene.machine.start()
    simulation = Simulation(scene)
    simulation.clock.displacement = 0.001
    whole = simulation.points()
    assert tuple(whole) == simulation.names_of_points
    monkeypatch.setattr(views, "PIECE", 5)
    for name, values in whole.items():
        assert np.array_equal(simulation.points(name)[name], values), name
        pieces = list(simulation.pieces(name))
        assert max(map(len, pieces)) <= 5 and np.array_equal(np.concatenate(pieces), values), name
    assert set(simulation.points("mass", "path")) == {"mass", "path"}
