"""Workers that die, runs that crash, and a sweep that is stopped: what is done stays done, and is done once."""

import json
import os
import signal
import sys
import textwrap
import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

from taichi_silo.errors import BadInput, Stopped
from taichi_silo.runs.observers import Observer
from taichi_silo.scene.scene import Scene
from taichi_silo.studies.sweep import clusters
from taichi_silo.studies.sweep.attempt import attempt
from taichi_silo.studies.sweep.clusters import Local, Scheduler, client_of
from taichi_silo.studies.sweep.file import of_tables
from taichi_silo.studies.sweep.progress import Told
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.studies.sweep.whole_sweep import TABLE, Study
from taichi_silo.utils.console import Console
from taichi_silo.utils.file_lock import alone

pytest.importorskip("distributed")
from taichi_silo.studies.sweep.dask_runner import Crew  # noqa: E402 - it needs dask.distributed

COARSE = {
    "grid": {"cell_size_m": 0.05}, "flow": {"displacement_m": 0.01, "speed_m_per_s": 0.02},
    "walls": {"kind": "smooth", "friction_angle_deg": 19.0}, "machine": {"lanes": False},
}  # fmt: skip
# a run for those who look at the workers only: its name says what it does
PROGRAM = """
    import json, os, signal, sys
    from pathlib import Path

    folder = Path(json.loads(sys.stdin.readline())["folder"])
    word = folder.name
    tries = folder.with_suffix(".tries")
    tries.write_text(tries.read_text() + "x" if tries.exists() else "x")
    print("0.5", flush=True)
    if word == "fails":
        sys.exit("the silo is empty")
    if word == "crashes" or (word == "recovers" and tries.read_text() == "x"):
        os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
    if word == "waits":
        sys.stdin.read()  # until it is stopped
        folder.with_suffix(".kept").write_text("")
        sys.exit(130)
    folder.with_suffix(".done").write_text("")
"""


@dataclass(frozen=True)
class Fake:
    """What a crew knows of a run."""

    folder: Path

    def order(self, steps: int = 0) -> str:
        return json.dumps({"folder": str(self.folder)})

    @property
    def finished(self) -> bool:
        return self.folder.with_suffix(".done").exists()

    @property
    def tries(self) -> int:
        tries = self.folder.with_suffix(".tries")
        return len(tries.read_text()) if tries.exists() else 0


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    folder = tmp_path_factory.mktemp("program")
    (folder / "run_of_a_test.py").write_text(textwrap.dedent(PROGRAM))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(folder), *sys.path]))
        yield ("run_of_a_test",)


@pytest.fixture(scope="module")
def client(program, tmp_path_factory):
    """Of one worker."""
    with client_of(Local(jobs=1), tmp_path_factory.mktemp("workers"), 1, retries=1) as client:
        yield client


def lead(client, program, folder: Path, *names: str, ended=None) -> tuple[dict[str, Fake], dict[str, str]]:
    """Let a crew do runs, each of which may be tried twice; returns them and what was heard of their ends."""
    runs, ends, heard = {name: Fake(folder / name) for name in names}, {}, []
    crew = Crew(client, 1, lambda *words: heard.append(words), program)
    crew.run(runs, {}, ended or (lambda name, trouble: ends.update({name: trouble})))
    assert {name for name, *_ in heard} <= set(names)
    return runs, ends


def test_a_crash_is_tried_again_and_a_run_that_says_no_is_not(client, program, tmp_path, tried):
    runs, ends = lead(client, program, tmp_path, "fails", "recovers", "crashes", "works")
    assert ends.pop("crashes").startswith("its process was ended by SIG") and runs["crashes"].tries == 2
    assert ends == {"fails": "the silo is empty", "recovers": "", "works": ""}
    assert {name: runs[name].tries for name in ends} == {"fails": 1, "recovers": 2, "works": 1}
    tried("faults survived", "run of a sweep killed", 3)
    tried("faults survived", "run of a sweep that fails")


def test_ctrl_c_lets_a_run_put_its_files_in_order_and_begins_no_other(client, program, tmp_path, tried):
    def ended(name, trouble):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lead(client, program, tmp_path, "works", "waits", "works-too", ended=ended)
    assert Fake(tmp_path / "works").finished and not Fake(tmp_path / "works-too").finished
    assert Fake(tmp_path / "waits").tries == 0 or (tmp_path / "waits.kept").exists()
    assert lead(client, program, tmp_path, "works-too")[1] == {"works-too": ""}, "the worker is free for another sweep"
    tried("faults survived", "sweep stopped by Ctrl-C")


def test_any_scheduler_does_that_answers(client, program, tmp_path, monkeypatch, tried):
    with client_of(Scheduler(address=client.scheduler.address), tmp_path, 1, 1) as other:
        assert lead(other, program, tmp_path, "works")[1] == {"works": ""}
    assert client.scheduler_info()["workers"], "it is left alone"
    monkeypatch.setattr(clusters, "ANSWER_S", 0.5)
    with pytest.raises(BadInput, match="scheduler is tcp://127.0.0.1:9; no scheduler of dask answers there"):
        client_of(Scheduler(address="tcp://127.0.0.1:9"), tmp_path, 1, 1).__enter__()
    tried("faults survived", "scheduler of a sweep that does not answer")


def test_a_worker_that_does_not_see_the_output_says_so(client, program, tmp_path, tried):
    _, ends = lead(client, program, tmp_path / "elsewhere", "works")
    assert "must be on a file system that all workers share" in ends["works"]
    tried("faults survived", "worker of a sweep without the output folder")


def test_nobody_outside_of_this_machine_reaches_the_workers(client):
    addresses = [client.scheduler.address, *client.scheduler_info()["workers"]]
    assert all(address.startswith("tcp://127.0.0.1:") for address in addresses)


class Interrupter(Observer):
    """Presses Ctrl-C in flow."""

    def observe(self, record):
        if record.stage == "flow":
            os.kill(os.getpid(), signal.SIGINT)


def test_a_run_that_was_left_goes_on_and_one_whose_checkpoints_are_damaged_begins_again(tmp_path, tried):
    scene = Scene.model_validate(COARSE | {"machine": {"lanes": False, "threads": 1}})
    run = Run(scene, tmp_path / "run")
    with pytest.raises(Stopped):
        attempt(run, (Interrupter(),))
    assert run.begun and not run.finished

    def resumed() -> int:
        return tomllib.loads((run.folder / "run.toml").read_text())["program"]["resumed"]

    attempt(run)
    assert run.finished and resumed() == 1
    with_film = Run(scene, run.folder, film=True)
    assert not with_film.finished and not with_film.begun, "what came to its end without a film begins again"
    toml = run.folder / "run.toml"
    toml.write_text(toml.read_text().replace("finished = true", "finished = false"))
    assert run.begun and not run.finished, "its last figures are not there yet"
    for file in run.folder.glob("checkpoint*.npz"):
        file.write_bytes(b"nothing")
    attempt(run)
    assert run.finished and resumed() == 0
    tried("faults survived", "run of a sweep left midway, its checkpoints whole or damaged", 2)


def test_two_sweeps_do_not_share_an_output(tmp_path, tried):
    one = study(tmp_path)
    tmp_path.mkdir(exist_ok=True)
    with alone(tmp_path / ".sweep", 0.0, ""), pytest.raises(BadInput, match="is in use by another sweep"):
        one.run()
    assert not (tmp_path / ".sweep").exists() and not (tmp_path / TABLE).exists()
    tried("faults survived", "two sweeps in one folder")


def study(folder: Path) -> Study:
    tables = {"scene": COARSE, "grid": {"method.cfl": ["default", 0.5, 1.5]}, "cluster": {"jobs": 2}}
    return Study(of_tables(tables, Path()), folder, Console(quiet=True))


def test_a_worker_killed_midway_costs_no_run_and_nothing_is_run_twice_without_need(tmp_path, monkeypatch, tried):
    begun, killed, hear = Counter(), [], Told.heard

    def heard(self, name, part, pid):
        begun[name] += part == 0.0
        if part > 0.0 and not killed:
            killed.append(name)
            os.kill(pid, getattr(signal, "SIGKILL", signal.SIGTERM))
        hear(self, name, part, pid)

    monkeypatch.setattr(Told, "heard", heard)
    one = study(tmp_path)
    one.run()
    assert len(killed) == 1 and begun == Counter([*one.runs, *killed])
    rows = pd.read_csv(tmp_path / TABLE).set_index("method.cfl")
    assert rows.finished.tolist() == [True, True, False], "the last one cannot be done"
    assert rows.N_largest_N_per_m.iloc[:2].gt(0.0).all() and rows.failure.iloc[:2].isna().all()
    assert "1.5 times the stable one" in rows.failure[1.5] and set(one.failures) == {rows.run[1.5]}
    assert {file.name for file in (tmp_path / "figures").iterdir()} == {"response.png", "forces.png"}
    assert not list(tmp_path.glob("*/.running"))
    assert set(study(tmp_path).missing) == set(one.failures), "what is finished is kept"
    tried("faults survived", "worker of a sweep killed")
