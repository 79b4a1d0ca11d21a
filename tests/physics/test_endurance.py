"""Long runs lose no sand, gain no memory, and a silo that was emptied fills again as if it had never been full."""

import pytest

from benchmarks import endurance
from taichi_silo import one_run, runtime


@pytest.fixture(autouse=True, scope="module")
def bare():
    """Figures take longer than these runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(one_run._Session, "_draw", lambda self: None)
        yield


def test_a_silo_that_is_emptied_by_gravity_fills_again_bit_by_bit_alike(tried):
    runtime.init()
    found = endurance.refill(cycles=2)
    assert found["points left, at most"] == 0 and found["fills alike bit by bit"]
    assert found["error of the books / mass"] < 1e-12 and found["largest balance residual / W"] < 1e-9
    tried("loads held", "silo emptied to the last point and filled again", found["fills"])


def test_a_run_of_many_steps_needs_no_more_memory_than_a_short_one(tmp_path, tried):
    found = endurance.million(tmp_path, steps=60_000)
    assert found["growth of memory"] < 0.01, found
    tried("loads held", "steps of a run with constant memory", found["steps"])


@pytest.mark.long
def test_nor_does_one_of_a_million_steps(tmp_path, tried):
    found = endurance.million(tmp_path)
    assert found["steps"] >= 1_000_000 and found["growth of memory"] < 0.01, found
    tried("loads held", "steps of a run with constant memory", found["steps"])


@pytest.mark.long
def test_at_the_papers_own_speed_nothing_drifts(tmp_path, tried):
    """Three minutes of it; `make endurance` takes half an hour."""
    found = endurance.slow(tmp_path, minutes=3.0)
    assert found["error of mass / mass"] < 1e-12 and found["largest balance residual / W"] < 1e-9
    assert found["void ratio lost without shear"] < 0.003 and found["growth of memory"] < 0.01
    assert found["alarms"] == 0
    tried("loads held", "steps at the paper's own 0.1 mm/s", found["steps"])
