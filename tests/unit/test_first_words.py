"""A run of hours says early that it goes on: in its log, and where no terminal shows a moving line."""

import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from taichi_silo.runs.observers import log, progress

RECORD = SimpleNamespace(
    time_s=1e-4, stage="filling", displacement_m=0.0, bottom_force_N_per_m=1e3, shear_N_per_m=1.0, normal_N_per_m=2.0,
    time_step_s=1e-6,
)  # fmt: skip
SIMULATION = SimpleNamespace(
    time=0.0, stage="filling", displacement=0.0, warnings=[], alarms=SimpleNamespace(found={}),
    model=SimpleNamespace(filling_time=10.0, period=0.1, flow_time=100.0), scene=SimpleNamespace(points=10),
)  # fmt: skip


@pytest.mark.parametrize(("seconds", "lines"), [(1.0, 0), (6.0, 1), (600.0, 1)])
def test_after_five_seconds_there_is_one_line_however_small_a_part_is_done(seconds, lines, tmp_path, monkeypatch):
    now = [0.0]
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr(log, "time", clock)
    monkeypatch.setattr(progress, "time", clock)
    monkeypatch.setattr(log, "runtime", SimpleNamespace(device=lambda: "cpu", threads=lambda: 1))
    said = io.StringIO()
    observers = [log.Log(tmp_path / "run.log"), progress.ProgressLine(Console(file=said, width=200))]
    for observer in observers:
        observer.begin(SIMULATION)
    for _ in range(3):
        now[0] += seconds / 3.0
        for observer in observers:
            observer.observe(RECORD)
    written = (tmp_path / "run.log").read_text()
    assert written.count("filling, 0 %") == said.getvalue().count("0.0 %") == lines


def test_what_is_noticed_when_the_flow_has_ended_is_said_as_well(tmp_path):
    """As that the sand lagged behind the gate: no record follows."""
    said = io.StringIO()
    simulation = SimpleNamespace(**vars(SIMULATION) | {"warnings": ["Early."]})
    line = progress.ProgressLine(Console(file=said, width=200))
    line.begin(simulation)
    line.observe(RECORD)
    simulation.warnings.append("The sand lags behind.")
    line.end()
    assert said.getvalue().count("Early.") == said.getvalue().count("Warning: The sand lags behind.") == 1
