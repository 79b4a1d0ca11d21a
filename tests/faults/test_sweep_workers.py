"""Workers that die, runs that crash, and a sweep that is stopped: what is done stays done, and is done once."""

import os
import signal
import sys
import textwrap
import time
import tomllib
from collections import Counter
from pathlib import Path

import pandas as pd
import pytest

from taichi_silo.errors import BadInput, Stopped
from taichi_silo.runs.observers import Observer
from taichi_silo.scene.scene import Scene
from taichi_silo.studies.sweep import clusters
from taichi_silo.studies.sweep.clusters import Scheduler
from taichi_silo.studies.sweep.plan import from_tables
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.studies.sweep.study import TABLE, Study
from taichi_silo.utils import process_pool
from taichi_silo.utils.console import Console
from taichi_silo.utils.file_lock import alone
from taichi_silo.utils.process_pool import Task
from taichi_silo.utils.progress import Progress

COARSE = {
    "grid": {"cell_size_m": 0.05}, "flow": {"displacement_m": 0.01, "speed_m_per_s": 0.02},
    "walls": {"kind": "smooth", "friction_angle_deg": 19.0}, "machine": {"lanes": False},
}  # fmt: skip
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
# a task for those who look at the workers only
PROGRAM = """
    import sys
    from pathlib import Path

    word, file = sys.stdin.readline().split()
    tries = Path(file + ".tries")
    tries.write_text(tries.read_text() + "x" if tries.exists() else "x")
    print("0.5", flush=True)
    if word == "fails":
        sys.exit("the silo is empty")
    if word == "waits" or word == "kills" and tries.read_text() == "x":
        sys.stdin.read()  # until it is stopped
        Path(file + ".kept").write_text("")
        sys.exit(130)
"""


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Of a scheduler of dask with one worker."""
    distributed = pytest.importorskip("distributed")
    folder = tmp_path_factory.mktemp("program")
    (folder / "task_of_a_test.py").write_text(textwrap.dedent(PROGRAM))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(folder), *sys.path]))
        with distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, host="127.0.0.1", memory_limit=0, dashboard_address=None
        ) as cluster:
            yield cluster.scheduler_address


def do(address: str, folder: Path, *words: str, ended=lambda name, failure: failure or "done") -> dict[str, str]:
    """Do tasks at the worker; the first is the longest. Returns why some failed."""
    with Scheduler(address=address).pool(folder, len(words), retries=1) as pool:
        tasks = [
            Task(word, ("task_of_a_test",), f"{word} {folder / word}", seconds=9.0 - k) for k, word in enumerate(words)
        ]
        return pool.run(tasks, ended=ended)


def test_a_scheduler_does_tasks_and_tells_how_far_they_are(address, tmp_path, monkeypatch, tried):
    heard = []
    monkeypatch.setattr(Progress, "heard", lambda self, *words: heard.append(words))
    assert do(address, tmp_path, "fails", "works") == {"fails": "the silo is empty"}
    assert {("works", 0.0), ("works", 0.5), ("fails", 0.5)} <= set(heard)
    monkeypatch.setattr(clusters, "ANSWER_S", 0.5)
    with pytest.raises(BadInput, match="scheduler is tcp://127.0.0.1:9; no scheduler of dask answers there"):
        do("tcp://127.0.0.1:9", tmp_path, "works")
    tried("faults survived", "scheduler of a sweep that does not answer")


def test_ctrl_c_stops_the_tasks_of_a_worker_and_leaves_it_to_others(address, tmp_path):
    def ended(name, failure):
        while not (tmp_path / "waits.tries").exists():
            time.sleep(0.05)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        do(address, tmp_path, "works", "waits", "never", ended=ended)
    assert (tmp_path / "waits.kept").exists() and not (tmp_path / "never.tries").exists()
    assert do(address, tmp_path, "works") == {}, "the worker is free for another sweep"


def test_a_worker_killed_midway_costs_no_task(address, tmp_path, monkeypatch, tried):
    from distributed import Client

    killed = []

    def heard(self, name, part):
        if part > 0.0 and not killed:
            killed.append(name)
            os.kill(worker, KILL)

    with Client(address, set_as_default=False) as client:
        (worker,) = client.run(os.getpid).values()
    monkeypatch.setattr(Progress, "heard", heard)
    assert do(address, tmp_path, "kills", "works") == {}
    assert killed == ["kills"] and (tmp_path / "kills.tries").read_text() == "xx"
    tried("faults survived", "worker of a sweep killed")


# --- the runs themselves ----------------------------------------------------------------------------------------------


def test_a_worker_that_does_not_see_the_output_says_so(tmp_path, tried):
    with pytest.raises(BadInput, match="no is not there on .* must be on a file system that all workers share"):
        Run(Scene.model_validate(COARSE), tmp_path / "no" / "run").attempt()
    tried("faults survived", "worker of a sweep without the output folder")


class Interrupter(Observer):
    """Presses Ctrl-C in flow."""

    def observe(self, record):
        if record.stage == "flow":
            os.kill(os.getpid(), signal.SIGINT)


def test_a_run_that_was_left_goes_on_and_one_whose_checkpoints_are_damaged_begins_again(tmp_path, tried):
    scene = Scene.model_validate(COARSE | {"machine": {"lanes": False, "threads": 1}})
    run = Run(scene, tmp_path / "run")
    with pytest.raises(Stopped):
        run.attempt((Interrupter(),))
    assert run.begun and not run.finished

    def resumed() -> int:
        return tomllib.loads((run.folder / "run.toml").read_text())["program"]["resumed"]

    run.attempt()
    assert run.finished and resumed() == 1
    with_film = Run(scene, run.folder, film=True)
    assert not with_film.finished and not with_film.begun, "what came to its end without a film begins again"
    toml = run.folder / "run.toml"
    toml.write_text(toml.read_text().replace("finished = true", "finished = false"))
    assert run.begun and not run.finished, "its last figures are not there yet"
    for file in run.folder.glob("checkpoint*.npz"):
        file.write_bytes(b"nothing")
    run.attempt()
    assert run.finished and resumed() == 0
    tried("faults survived", "run of a sweep left midway, its checkpoints whole or damaged", 2)


def study(folder: Path) -> Study:
    tables = {"scene": COARSE, "grid": {"method.cfl": ["default", 0.5, 1.5]}, "cluster": {"jobs": 2}}
    return Study(from_tables(tables, Path()), folder, Console(quiet=True))


def test_two_sweeps_do_not_share_an_output(tmp_path, tried):
    one = study(tmp_path)
    with alone(tmp_path / ".sweep", 0.0, ""), pytest.raises(BadInput, match="is in use by another sweep"):
        one.run()
    assert not (tmp_path / ".sweep").exists() and not (tmp_path / TABLE).exists()
    tried("faults survived", "two sweeps in one folder")


def test_a_run_killed_midway_is_not_lost_and_nothing_is_run_twice_without_need(tmp_path, monkeypatch, tried):
    begun, killed, hear = Counter(), [], Progress.heard

    def heard(self, name, part):
        begun[name] += part == 0.0
        if part > 0.0 and not killed:
            killed.append(name)
            for child in next(iter(process_pool._children.values())):
                if name in child.line:
                    child.process.kill()
        hear(self, name, part)

    monkeypatch.setattr(Progress, "heard", heard)
    monkeypatch.setattr(process_pool, "_children", {})
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
    tried("faults survived", "run of a sweep killed midway")
