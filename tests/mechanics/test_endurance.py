"""Long runs lose no sand, gain no memory, and a silo that was emptied fills again as if it had never been full."""

import pytest

from benchmarks import endurance
from taichi_silo.mpm import runtime
from taichi_silo.runs.observers import Observer, wall_profiles
from taichi_silo.runs.observers.checkpoint import Checkpoint
from taichi_silo.runs.session import run
from taichi_silo.scene.scene import Flow, Output
from tests.smallest import smallest

pytestmark = pytest.mark.usefixtures("bare")


@pytest.mark.long
def test_a_silo_that_is_emptied_by_gravity_fills_again_bit_by_bit_alike(tried):
    runtime.init()
    found = endurance.refill(cycles=2)
    assert found["points left, at most"] == 0 and found["fills alike bit by bit"]
    assert found["error of the books / mass"] < 1e-12 and found["largest balance residual / W"] < 1e-9
    tried("loads held", "silo emptied to the last point and filled again", found["fills"])


def size(kept) -> int:
    """Bytes of what an observer keeps, about."""
    if isinstance(kept, dict):
        return sum(size(value) for value in kept.values())
    return getattr(kept, "nbytes", len(str(kept)))


class Sizes(Observer):
    """What all observers keep, after each fiftieth record of flow, until the states for the flow pattern are kept."""

    def __init__(self):
        self.count, self.bytes = 0, []

    def observe(self, record):
        self.count += record.stage == "flow"
        if record.stage == "flow" and record.displacement_m < 0.026 and self.count % 50 == 0:
            self.bytes.append(sum(size(one.state()) for one in self.checkpoint.observers.values()))


def test_what_is_kept_of_a_run_does_not_grow_with_its_records(tmp_path, monkeypatch):
    sizes, begin = Sizes(), Checkpoint.begin
    monkeypatch.setattr(Checkpoint, "begin", lambda self, s: setattr(sizes, "checkpoint", self) or begin(self, s))
    monkeypatch.setattr(wall_profiles, "MOST_BLOCKS", 2)
    changed = {"output": Output(snapshots=1), "flow": Flow(speed_m_per_s=0.02, displacement_m=0.03)}
    run(smallest(**changed), tmp_path / "run", extra=(sizes,))
    assert len(sizes.bytes) > 12, "whole blocks of profiles"
    assert max(sizes.bytes[6:]) < 1.03 * max(sizes.bytes[:6])


@pytest.mark.long
def test_a_run_of_a_million_steps_needs_no_more_memory_than_a_short_one(tmp_path, tried):
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
