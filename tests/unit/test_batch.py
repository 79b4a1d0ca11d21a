"""Runs that one process does together: on a graphics card, whose part parallel tasks of the processor take here."""

import json

import numpy as np
import pandas as pd
import pytest

from taichi_silo.mpm import one_taichi, runtime
from taichi_silo.mpm.solver import Solver
from taichi_silo.scene.scene import Machine
from taichi_silo.studies.sweep.batch import MOST, alike, attempt, lines
from taichi_silo.studies.sweep.processes import simulate
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.console import Console
from taichi_silo.utils.process_pool import ProcessPool
from tests.smallest import smallest


@pytest.fixture
def by_tasks(monkeypatch):
    built = Solver.__init__
    monkeypatch.setattr(Solver, "__init__", lambda self, *a, **k: built(self, *a, **(k | {"shared": True})))


def runs_of(folder, *speeds, **parts):
    return {f"{speed}": Run(smallest(flow={"speed_m_per_s": speed}, **parts), folder / f"{speed}") for speed in speeds}


def test_runs_of_a_batch_leave_what_each_leaves_alone(tmp_path, by_tasks, capsys):
    for name in ("alone", "together"):
        (tmp_path / name).mkdir()
    alone, together = runs_of(tmp_path / "alone", 0.04, 0.05), runs_of(tmp_path / "together", 0.04, 0.05)
    for name, run in alone.items():
        assert attempt(lines({name: run}, {})) == [""]
    assert attempt(lines(together, {name: 3000 for name in together})) == ["", ""]
    said = [float(line) for line in capsys.readouterr().out.splitlines() if line[:2] == "0."]
    assert said == sorted(said) and 0.8 < said[-1] < 1.0
    for name, run in together.items():
        largest = 1.0  # force: round-off of what forces leave of each other is that of the forces
        for file in ("forces.csv", "walls.csv", "balance.csv"):
            one, other = (pd.read_csv(of.folder / file).select_dtypes("number") for of in (run, alone[name]))
            assert list(one) == list(other) and one.shape == other.shape
            forces = one.columns.str.endswith("_N_per_m")
            largest = max(largest, one.loc[:, forces].abs().max().max()) if forces.any() else largest
            size = np.maximum(one.abs().max(), np.where(forces, largest, 1.0))
            assert ((one - other).abs().max() <= 1e-12 * size).all(), (name, file)
        assert run.finished and (run.folder / "figures" / "forces.png").exists()


def test_a_run_of_a_batch_that_fails_says_so_and_the_others_end(tmp_path, by_tasks):
    runs = runs_of(tmp_path, 0.04, 0.05)
    runs["gone"] = Run(runs["0.04"].scene, tmp_path / "nowhere" / "gone")
    why = attempt(lines(runs, {}))
    assert why[:2] == ["", ""] and why[2].startswith(f"output {tmp_path / 'nowhere'} is not there")
    assert runs["0.04"].finished and runs["0.05"].finished


def test_a_stop_stops_all_runs_of_a_batch_and_each_can_go_on(tmp_path, by_tasks, monkeypatch):
    runs = runs_of(tmp_path, 0.04, 0.05)
    wait, times = runtime.wait, []

    def interrupt():
        import signal

        times.append(1)
        if len(times) == 40:
            signal.raise_signal(signal.SIGINT)
        wait()

    monkeypatch.setattr(runtime, "wait", interrupt)
    assert attempt(lines(runs, {})) == ["stopped", "stopped"]
    assert all(run.begun and (run.folder / "checkpoint.npz").exists() for run in runs.values())
    assert attempt(lines(runs, {})) == ["", ""]
    assert all(run.finished for run in runs.values())


def test_runs_on_a_card_go_together_and_others_alone(tmp_path):
    card = Machine(arch="vulkan", threads=1)
    on_card = runs_of(tmp_path, *(0.01 * n for n in range(1, MOST + 3)), machine=card)
    other = {"four points": Run(smallest(machine=card, grid={"points_per_cell": 4}), tmp_path / "four")}
    on_cpu = {"cpu": Run(smallest(), tmp_path / "cpu"), "cpu 2": Run(smallest(), tmp_path / "cpu2")}
    names = list(on_card)
    assert alike(on_card | other | on_cpu) == [names[:MOST], names[MOST:], ["four points"], ["cpu"], ["cpu 2"]]


def test_a_sweep_with_a_card_has_one_process_and_hears_of_each_run(tmp_path):
    class Pool(ProcessPool):
        def run(self, tasks, console, ended):
            assert self.jobs == 1
            (task,) = tasks
            assert len(json.loads(task.line)) == 2
            ended(task.name, json.dumps(["no sand", "no silo"]))
            return {}

    runs = runs_of(tmp_path, 0.04, 0.05, machine=Machine(arch="vulkan", threads=1))
    heard = {}
    failures = simulate(runs, Pool(4), Console(quiet=True), ended=heard.__setitem__)
    assert failures == heard == {"0.04": "no sand", "0.05": "no silo"}


def test_taichi_is_free_after_a_batch(tmp_path, by_tasks):
    assert attempt(lines(runs_of(tmp_path, 0.04, 0.05), {})) == ["", ""]
    assert one_taichi.crew() is None
    runtime.init()
