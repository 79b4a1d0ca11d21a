"""Ctrl-C and the signal to end, at every stage: an exit code, a sentence, and a run that goes on from there."""

import os
import signal
import subprocess
import sys

import pytest

from taichi_silo.errors import BadInput, Stopped
from taichi_silo.runs import session
from taichi_silo.runs.observers import Observer
from taichi_silo.runs.session import resume, run
from taichi_silo.utils import checked_npz, file_lock
from tests.faults.harness import ROOT, At, assert_same, assert_sound, contents, failed, send
from tests.smallest import SMALLEST

pytestmark = pytest.mark.usefixtures("quick")
BOTH = pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])


def stopped(number, folder, **how):
    with pytest.raises(Stopped) as caught:
        run(SMALLEST, folder, **how)
    assert caught.value.code == 128 + number
    assert not (folder / file_lock.NAME).exists()
    return str(caught.value)


@BOTH
def test_while_it_compiles_nothing_has_begun_and_nothing_is_lost(number, tmp_path, whole, monkeypatch, capsys, tried):
    begin = session.Simulation

    def compiling(scene):
        send(number)()
        raise AssertionError("it went on")

    monkeypatch.setattr(session, "Simulation", compiling)
    assert stopped(number, tmp_path / "run") == session.BEFORE
    assert not contents(tmp_path / "run")
    again = tmp_path / "again"
    with monkeypatch.context() as patch:
        patch.setattr(session, "Simulation", begin)
        stopped(number, again, extra=(At(5, send(number)),))
    before = contents(again)
    code, err = failed(monkeypatch, capsys, "resume", again, "--quiet")
    assert code == 128 + number and err.startswith("Error: stopped before the run went on; nothing has changed")
    assert contents(again) == before
    with pytest.raises(Stopped):
        run(SMALLEST, again, overwrite=True)
    assert contents(again) == before, "it is not yet replaced"
    tried("faults survived", "stopped while it compiles", 3)


def test_while_the_scene_is_read_nothing_has_begun(tmp_path, monkeypatch, capsys, tried):
    """Before a run hears signals Python's own answer to Ctrl-C is what comes, which a shell's background lacks."""
    (tmp_path / "silo.toml").write_text("")
    monkeypatch.setattr("taichi_silo.scene.scene_files.read_scene", lambda *_: send()())
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        code, err = failed(monkeypatch, capsys, "run", tmp_path / "silo.toml", "--output", tmp_path / "run")
    finally:
        signal.signal(signal.SIGINT, before)
    assert (code, err) == (130, f"Error: {session.BEFORE}.")
    assert not (tmp_path / "run").exists()
    tried("faults survived", "stopped while its scene is read")


@BOTH
def test_while_the_cost_is_rehearsed_no_folder_is_left(number, tmp_path, whole, tried):
    """Nor the ones around it; of a run that would have been replaced nothing is touched."""

    class Rehearsal(Observer):
        def prepare(self, simulation):
            send(number)()
            raise AssertionError("it went on")

    assert stopped(number, tmp_path / "new" / "run", extra=(Rehearsal(),)) == session.BEFORE
    assert not (tmp_path / "new").exists()
    there = tmp_path / "there"
    stopped(number, there, extra=(At(5, send(number)),))
    before = contents(there)
    assert stopped(number, there, overwrite=True, extra=(Rehearsal(),)) == session.BEFORE
    assert contents(there) == before
    empty = tmp_path / "empty"
    empty.mkdir()
    stopped(number, empty, extra=(Rehearsal(),))
    assert empty.is_dir(), "it was the user's"
    tried("faults survived", "stopped while its cost is rehearsed", 3)


@BOTH
@pytest.mark.parametrize("stage", ["filling", "flow"])
@pytest.mark.parametrize("times", [1, 3], ids=["once", "three times"])
def test_while_it_fills_or_flows(number, stage, times, tmp_path, whole, tried):
    folder = tmp_path / "run"
    words = stopped(number, folder, extra=(At(5, send(number, times), stage, at_end=send(number, times - 1)),))
    assert words.startswith("stopped at t = 0.") and f"({stage}, u = " in words
    assert words.endswith(f"`taichi-silo resume {folder}` goes on from there")
    assert {"summary.json", "walls.csv", "run.toml", "checkpoint.npz"} <= contents(folder).keys()
    assert_sound(folder, whole)
    resume(folder)
    assert_same(folder, whole)
    tried("faults survived", f"stopped while it {'fills' if stage == 'filling' else 'flows'}")


@BOTH
def test_while_a_checkpoint_is_written_it_is_written_whole(number, tmp_path, whole, monkeypatch, tried):
    folder, write, count = tmp_path / "run", checked_npz.write, 0

    def interrupted(file, tree):
        nonlocal count
        count += 1
        if count == 2:
            send(number)()
        write(file, tree)

    monkeypatch.setattr(checked_npz, "write", interrupted)
    assert "flow, u = " in stopped(number, folder), "after the filling"
    assert_sound(folder, whole)
    resume(folder)
    assert_same(folder, whole)
    tried("faults survived", "stopped while a checkpoint is written")


@BOTH
def test_while_figures_are_drawn_the_rest_is_there(number, tmp_path, whole, tried):
    folder = tmp_path / "run"

    def drawing(folder):
        send(number)()
        raise AssertionError("it went on")

    assert stopped(number, folder, drawing=(drawing,)).startswith("stopped while film and figures were drawn; all else")
    assert "finished = false" in (folder / "run.toml").read_text()
    resume(folder)
    assert_same(folder, whole)
    tried("faults survived", "stopped while figures are drawn")


@BOTH
def test_a_run_that_is_stopped_is_not_drawn_but_is_when_it_goes_on(number, tmp_path, whole, tried):
    folder, drawn = tmp_path / "run", []
    drawing = {"drawing": (drawn.append,)}
    stopped(number, folder, extra=(At(5, send(number)),), **drawing)
    stopped(number, folder, overwrite=True, extra=(At(-1, send(number), at_end=send(number)),), **drawing)
    assert not drawn
    resume(folder, **drawing)
    assert drawn == [folder]
    assert_same(folder, whole)
    tried("faults survived", "stopped once more while it puts its files in order", 2)


# --- others -----------------------------------------------------------------------------------------------------------


def test_a_second_run_in_the_same_folder_is_refused_until_the_first_is_gone(left):
    program = "import sys; from pathlib import Path; from taichi_silo.utils import file_lock\n"
    program += "with file_lock.held(Path(sys.argv[1])): print('held', flush=True); input()"
    holder = subprocess.Popen(
        [sys.executable, "-c", program, left], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    assert holder.stdout.readline() == "held\n"
    before = contents(left)
    for attempt in (lambda: resume(left), lambda: run(SMALLEST, left, overwrite=True)):
        with pytest.raises(BadInput, match=rf"in use by another run \(process {holder.pid}\)"):
            attempt()
    assert contents(left) == before
    holder.kill()
    holder.wait()
    assert (left / file_lock.NAME).exists(), "what is left of it is in nobody's way"
    with file_lock.held(left):
        pass
    assert not (left / file_lock.NAME).exists()


class Runner:
    """A run that says that it runs, and goes on until it is let go."""

    def __init__(self, scene, folder, extra, drawing):
        self.folder = folder

    def prepare(self):
        pass

    def go(self, stops):
        (self.folder / "run.toml").write_text("")
        os.write(Runner.says, b"R")
        os.read(Runner.waits, 1)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="it takes processes that start at one instant")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_of_eight_that_start_at_one_instant_exactly_one_runs(quick, tmp_path, monkeypatch, tried):
    monkeypatch.setattr(session, "_Session", Runner)
    rounds, processes = 25, 8
    for number in range(rounds):
        folder = tmp_path / f"run{number}"
        heard, Runner.says = os.pipe()
        Runner.waits, let_go = os.pipe()
        gate, open_gate = os.pipe()
        children = []
        for _ in range(processes):
            child = os.fork()
            if child == 0:
                said = b"W"  # wrong
                try:
                    os.close(open_gate)
                    os.close(let_go)
                    os.read(gate, 1)
                    run(SMALLEST, folder)
                    said = b""
                except BadInput as error:
                    busy = ("in use by another run", "holds a run already")
                    said = b"B" if any(words in str(error) for words in busy) else b"W"
                finally:
                    os.write(Runner.says, said)
                    os._exit(0)
            children.append(child)
        os.close(open_gate)
        told = b""
        while len(told) < processes:
            told += os.read(heard, 1)
        os.close(let_go)
        for child in children:
            os.waitpid(child, 0)
        for end in (heard, Runner.says, Runner.waits, gate):
            os.close(end)
        assert sorted(told.decode()) == [*"B" * (processes - 1), "R"], told
        assert not (folder / file_lock.NAME).exists()
    tried("faults survived", "eight runs of one folder starting at one instant", rounds)
