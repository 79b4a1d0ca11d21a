"""Memory of the vector unit's arrays goes back to the system between launches, and not a bit of a run changes."""

import sys

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import NAME
from taichi_silo.mpm.pages import give_back
from taichi_silo.mpm.simd import executor
from taichi_silo.mpm.simd.vectors import eight
from taichi_silo.simulation.clock import Interval
from taichi_silo.simulation.simulation import Simulation
from tests.smallest import smallest

LENGTH = 1 << 17  # of eights: 8 MiB


def resident():
    """Memory of this process that is there [bytes]."""
    with open("/proc/self/statm") as file:
        return 4096 * int(file.read().split()[1])


@pytest.mark.skipif(
    sys.platform != "linux" or NAME != "taichi", reason="memory goes back on Linux, under Taichi itself"
)
def test_what_is_handed_back_is_zero_and_takes_no_memory_until_it_is_used():
    runtime.init()
    array = runtime.array(eight, LENGTH)
    array.fill(3.0)
    full = resident()
    give_back(array)
    assert resident() < full - 0.9 * 64 * LENGTH
    middle = LENGTH // 2  # pages that are shared with others, at both ends, stay as they are
    assert not array[middle].to_numpy().any()
    array.fill(4.0)
    assert (array[middle].to_numpy() == 4.0).all()


def test_a_simulation_that_rests_between_two_records_goes_on_as_if_it_had_not(monkeypatch):
    monkeypatch.setattr(executor, "LARGE", 0)
    found = []
    for rests in (False, True):
        scene = smallest()
        scene.machine.start()
        simulation = Simulation(scene)
        for _ in range(3):
            simulation.advance(Interval(simulation.model.interval, gravity=(1.0, 1.0)))
            if rests:
                simulation.solver.executor.rest()
        found.append(simulation.points() | vars(simulation.sums))
    for name, values in found[0].items():
        assert np.array_equal(values, found[1][name]), name
