"""Tasks in processes: their order, their troubles, and their end with or without their parent."""

import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from taichi_silo.utils.process_pool import Processes, Task

ROOT = Path(__file__).parents[2]
PROGRAM = """
    import sys, time
    from pathlib import Path
    from taichi_silo.child import given

    try:
        word = given().strip()
        print("0.5", flush=True)  # whoever hears it may interrupt at once
        if word == "fail":
            print("x" * 200_000, file=sys.stderr)
            sys.exit("the silo is empty")
        while word.startswith("wait"):
            time.sleep(0.01)
    except KeyboardInterrupt:
        Path(word.split()[1]).write_text("kept")
        sys.exit(130)
"""
PARENT = """
    import sys
    from taichi_silo.processes import Processes, Task

    def heard(task, line):
        print("ready", flush=True)
        return 0.5

    Processes(1).run([Task("long", ("task_of_a_test",), sys.argv[1])], heard)
"""


@pytest.fixture
def task(tmp_path, monkeypatch):
    """Make a task of a word."""
    (tmp_path / "task_of_a_test.py").write_text(textwrap.dedent(PROGRAM))
    path = f"{tmp_path}{os.pathsep}{ROOT}"
    monkeypatch.setenv("PYTHONPATH", path)
    return lambda name, word, seconds=1.0: Task(name, ("task_of_a_test",), word, {"PYTHONPATH": path}, seconds)


def comes(file: Path) -> bool:
    """Whether a file comes into being within some seconds."""
    end = time.monotonic() + 15.0
    while not file.exists() and time.monotonic() < end:
        time.sleep(0.05)
    return file.exists()


def test_the_longest_begins_first_and_one_that_fails_stops_no_other(task):
    said, ends = [], []

    def ended(one, trouble):
        ends.append(one.name)
        return trouble or "done"

    tasks = [task("short", "", 1.0), task("fails", "fail", 2.0), task("long", "", 3.0)]
    troubles = Processes(1, said.append).run(tasks, lambda one, line: float(line), ended)
    assert ends == ["long", "fails", "short"]
    assert troubles == {"fails": "the silo is empty"}
    assert said[-1].startswith("100.0 %") and "0.0 min left" in said[-1]
    assert said[0].split()[0] == "25.0", "half of the longest, which is half of the whole"


def test_an_interrupt_lets_the_children_put_their_files_in_order(task, tmp_path):
    def heard(one, line):
        raise KeyboardInterrupt

    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        Processes(1).run([task("long", f"wait {tmp_path / 'kept'}"), task("never", f"wait {tmp_path / 'no'}")], heard)
    assert (tmp_path / "kept").exists() and not (tmp_path / "no").exists()
    assert time.monotonic() - begun < 15.0, "without waiting for the grace to pass"


def test_no_task_begins_between_an_interrupt_and_the_stop(task, tmp_path):
    class Slow(Processes):
        def _stop(self):
            time.sleep(1.0)
            super()._stop()

    def heard(one, line):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Slow(1).run([task("long", f"wait {tmp_path / 'kept'}"), task("never", f"wait {tmp_path / 'no'}")], heard)
    assert (tmp_path / "kept").exists() and not (tmp_path / "no").exists()


def test_no_child_outlives_a_parent_that_was_killed(task, tmp_path):
    command = [sys.executable, "-c", textwrap.dedent(PARENT), f"wait {tmp_path / 'kept'}"]
    parent = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert "ready" in parent.stdout.readline()
    parent.kill()
    parent.wait()
    assert comes(tmp_path / "kept")
