"""Tasks in processes: their order, their failures, and their end with or without their parent."""

import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from taichi_silo.utils import process_pool
from taichi_silo.utils.console import Console
from taichi_silo.utils.process_pool import ProcessPool, Task
from taichi_silo.utils.progress import Progress

ROOT = Path(__file__).parents[2]
PROGRAM = """
    import os, signal, sys, time
    from pathlib import Path
    from taichi_silo.utils.child_process import given

    try:
        word, *file = given().split()
        print("0.5", flush=True)
        if word == "fail":
            print("x" * 200_000, file=sys.stderr)
            sys.exit("the silo is empty")
        if word in ("crash", "recover"):
            tries = Path(file[0])
            tries.write_text(tries.read_text() + "x" if tries.exists() else "x")
            if word == "crash" or tries.read_text() == "x":
                os.kill(os.getpid(), signal.SIGTERM)
        while word == "wait":
            time.sleep(0.01)
    except KeyboardInterrupt:
        Path(*file).write_text("kept")
        sys.exit(130)
"""


@pytest.fixture
def task(tmp_path, monkeypatch):
    """Make a task of a word."""
    (tmp_path / "task_of_a_test.py").write_text(textwrap.dedent(PROGRAM))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(ROOT)]))
    return lambda name, word="work", seconds=1.0: Task(name, ("task_of_a_test",), word, seconds=seconds)


def comes(file: Path) -> bool:
    """Whether a file comes into being within some seconds."""
    end = time.monotonic() + 15.0
    while not file.exists() and time.monotonic() < end:
        time.sleep(0.05)
    return file.exists()


def test_the_longest_begins_first_and_one_that_fails_stops_no_other(task, capsys):
    ends = []

    def ended(name, failure):
        ends.append(name)
        return failure or "done"

    tasks = [task("short", "work", 1.0), task("fails", "fail", 2.0), task("long", "work", 3.0)]
    assert ProcessPool(1).run(tasks, Console(), ended) == {"fails": "the silo is empty"}
    assert ends == ["long", "fails", "short"]
    said = capsys.readouterr().out.splitlines()
    assert said[0].split()[0] == "25.0", "half of the longest, which is half of the whole"
    assert said[-1] == "100.0 %  3 of 3 runs, 0.0 min left  short: done"


def test_a_crash_is_tried_again_and_a_task_that_says_no_is_not(task, tmp_path, tried):
    words = {name: f"{name} {tmp_path / name}" for name in ("fail", "crash", "recover", "work")}
    failures = ProcessPool(2, retries=1).run([task(name, word) for name, word in words.items()])
    assert failures == {"fail": "the silo is empty", "crash": "its process was ended by SIGTERM, 2 times"}
    assert (tmp_path / "crash").read_text() == (tmp_path / "recover").read_text() == "xx"
    tried("faults survived", "run of a sweep killed", 3)
    tried("faults survived", "run of a sweep that fails")


def test_an_interrupt_lets_the_tasks_put_their_files_in_order_and_begins_no_other(task, tmp_path, monkeypatch, tried):
    """No other begins between the interrupt and the stop, either."""
    kept, begun = tmp_path / "kept", []
    follow, stop = process_pool._follow, ProcessPool._stop
    monkeypatch.setattr(process_pool, "_follow", lambda child, heard: (begun.append(child.line), follow(child, heard)))
    monkeypatch.setattr(ProcessPool, "_stop", lambda self, kill=False: (time.sleep(0.2), stop(self, kill))[1])

    def ended(name, failure):
        while not any(line.startswith("wait") for line in begun):
            time.sleep(0.01)
        time.sleep(0.5)
        raise KeyboardInterrupt

    tasks = [
        task("first", "work", 3.0),
        task("long", f"wait {kept}", 2.0),
        task("never", f"wait {tmp_path / 'no'}", 1.0),
    ]
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        ProcessPool(1).run(tasks, ended=ended)
    assert kept.exists() and len(begun) == 2
    assert time.monotonic() - start < 15.0, "without waiting for the grace to pass"
    tried("faults survived", "sweep stopped by Ctrl-C")


def test_no_task_outlives_a_parent_that_was_killed(task, tmp_path):
    script = "import sys; from taichi_silo.utils.process_pool import *\n"
    script += "ProcessPool(1).run([Task('long', ('task_of_a_test',), sys.argv[1])], Console())"
    command = [sys.executable, "-c", script, f"wait {tmp_path / 'kept'}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert "50.0 %" in parent.stdout.readline()
        parent.kill()
    assert comes(tmp_path / "kept")


def test_time_left_follows_the_pace_and_the_longest_task(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("taichi_silo.utils.progress.time.monotonic", lambda: now[0])
    progress = Progress(Console(quiet=True).terminal, {"long": 60.0, "short": 20.0, "other": 20.0}, jobs=2)
    assert progress.left_s == 60.0, "before anything is known, no less than the longest"
    now[0] += 20.0
    progress.ended("short", "")
    progress.heard("short", 0.5)
    assert progress.share == pytest.approx(0.2), "what is heard of a task after its end does not count"
    progress.heard("long", 20.0 / 60.0)
    assert progress.left_s == pytest.approx(40.0), "of the longest; all together would take 30 s"
    progress.heard("long", 0.0)
    assert progress.share == pytest.approx(0.2), "begun again"
    for name in ("long", "other"):
        progress.ended(name, "")
    assert progress.left_s == 0.0
