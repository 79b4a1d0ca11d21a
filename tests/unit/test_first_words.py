"""A run of hours says early that it goes on: in its log, and where no terminal shows a moving line."""

import io
import math
from types import SimpleNamespace

import pytest
from rich.console import Console

from taichi_silo.runs.observers import log, progress
from taichi_silo.scene.silo import Silo

RECORD = SimpleNamespace(
    time_s=1e-4, stage="filling", displacement_m=0.0, time_step_s=1e-6,
    forces={"P": 1e3, "T": 1.0, "N": 2.0},
)  # fmt: skip
SIMULATION = SimpleNamespace(
    time=0.0, stage="filling", displacement=0.0, warnings=[], alarms=SimpleNamespace(found={}),
    model=SimpleNamespace(filling_time=10.0, period=0.1, flow_time=100.0),
    scene=SimpleNamespace(points=10, silo=Silo()),
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


def test_where_no_wall_is_vertical_t_and_n_are_those_of_the_inclined_ones_and_it_is_said(tmp_path, monkeypatch):
    """Walls at 45 degrees that push with 30 N/m across themselves and 10 N/m upwards along themselves."""
    monkeypatch.setattr(log, "runtime", SimpleNamespace(device=lambda: "cpu", threads=lambda: 1))
    monkeypatch.setattr(log, "SOON_S", 0.0)
    monkeypatch.setattr(progress, "SOON_S", 0.0)
    half = math.sqrt(0.5)
    bodies = {"left_horizontal": 20.0, "left_vertical": 40.0, "right_horizontal": -20.0, "right_vertical": 40.0}
    forces = {"P": 1e3, "T": 0.0, "N": 0.0} | {f"hopper_{name}_N_per_m": half * f for name, f in bodies.items()}
    scene = SimpleNamespace(points=10, silo=Silo.polygon([(0.2, 0), (0.3, 0), (0.5, 0.2), (0, 0.2)]))
    simulation, said = SimpleNamespace(**vars(SIMULATION) | {"scene": scene}), io.StringIO()
    observers = [log.Log(tmp_path / "run.log"), progress.ProgressLine(Console(file=said, width=200))]
    for observer in observers:
        observer.begin(simulation)
        observer.observe(SimpleNamespace(**vars(RECORD) | {"forces": forces}))
    assert "P 1, T 0.01, N 0.03 kN/m" in (tmp_path / "run.log").read_text()
    assert "P 1.000  T 0.010  N 0.030 kN/m" in said.getvalue()
    for words in ((tmp_path / "run.log").read_text(), said.getvalue()):
        assert words.count("T, N: mean of the inclined walls") == 1
