"""Whatever ends a run, and whatever befalls its checkpoints, it goes on, or says in a sentence why it cannot."""

import errno
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from taichi_silo import Flow, Machine, Mesh, Method, Scene, Silo
from taichi_silo.cli import app
from taichi_silo.errors import BadInput, Stopped
from taichi_silo.runs import session
from taichi_silo.runs.observers import Observer, checkpoint
from taichi_silo.runs.observers.checkpoint import NAME, PREVIOUS
from taichi_silo.runs.session import resume, run
from taichi_silo.scene.scene import Output
from taichi_silo.utils import checked_npz, file_lock

ROOT = Path(__file__).parents[2]
SCENE = Scene(
    silo=Silo(height_m=0.4), grid=Mesh(cell_size_m=0.05), flow=Flow(speed_m_per_s=0.02, displacement_m=0.01),
    method=Method(filling_time_s=0.1, longest_settling_s=0.0), machine=Machine(threads=1, lanes=False),
)  # fmt: skip
CHILD = """
import sys
from pathlib import Path
from taichi_silo import Scene, cli, one_run
from taichi_silo.observers import checkpoint
one_run._Session._draw = lambda self: None
scene, folder = Scene.model_validate_json(sys.argv.pop(1)), Path(sys.argv.pop(1))
def go():
    one_run.resume(folder) if checkpoint.is_there(folder) else one_run.run(scene, folder, overwrite=True, film=False)
cli.command(go)
"""


class Presser(Observer):
    """Presses Ctrl-C after so many records."""

    def __init__(self, records):
        self.left = records

    def observe(self, record):
        self.left -= 1
        if self.left == 0:
            os.kill(os.getpid(), signal.SIGINT)


class Counter(Observer):
    """Counts the records."""

    records = 0

    def observe(self, record):
        self.records += 1


@pytest.fixture(autouse=True, scope="module")
def bare():
    """Figures take longer than these runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session._Session, "_draw", lambda self: None)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a run that nothing befell."""
    return run(SCENE, tmp_path_factory.mktemp("runs") / "whole", film=False)


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """That of one that was stopped in the flow; it has two checkpoints, after filling and of the stop."""
    folder = tmp_path_factory.mktemp("runs") / "stopped"
    with pytest.raises(Stopped):
        run(SCENE, folder, film=False, extra=(Presser(280),))
    assert json.loads((folder / "summary.json").read_text())["failure"].startswith("stopped at t = ")
    return folder


@pytest.fixture
def left(stopped, tmp_path):
    """A copy of that, to be spoiled."""
    return Path(shutil.copytree(stopped, tmp_path / "left"))


def assert_same(one, other):
    for name in ("forces.csv", "balance.csv", "walls.csv", "snapshots/filled.vtu", "snapshots/flow_010.000mm.vtu"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def spoil(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0xFF
    file.write_bytes(content)


# --- the file ---------------------------------------------------------------------------------------------------------

TREE = {
    "clock": {"time": 0.1 + 0.2, "stage": "flow", "nothing": None, "least": sys.float_info.min, "over": float("inf")},
    "points": {"position": np.random.default_rng(1).random((50, 2)), "identity": np.arange(50), "h": np.zeros((0, 4))},
    "names": np.array(["filling", "flow"]),
}


def equal(one, other):
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(equal(one[name], other[name]) for name in one)
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and (one == other).all()
    return one == other


@pytest.fixture
def file(tmp_path):
    checked_npz.write(tmp_path / "tree.npz", TREE)
    return tmp_path / "tree.npz"


def test_what_was_written_comes_back_bit_by_bit(file):
    header, tree = checked_npz.read(file)
    assert equal(tree, TREE) and equal(TREE, tree)
    assert header["format"] == checked_npz.FORMAT and header["taichi_silo"]


def test_no_damage_passes_for_what_was_written(file):
    """Any byte turned, any end missing: found out, or without effect (dates, padding)."""
    whole, rng, found = file.read_bytes(), random.Random(2), 0
    for _ in range(300):
        content = bytearray(whole)
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        file.write_bytes(content)
        try:
            assert equal(checked_npz.read(file)[1], TREE)
        except checked_npz.Damaged:
            found += 1
    assert found > 200
    for _ in range(30):
        file.write_bytes(whole[: rng.randrange(len(whole))])
        with pytest.raises(checked_npz.Damaged):
            checked_npz.read(file)


def test_numbers_that_were_changed_by_hand_do_not_fit_the_checksum(file):
    with np.load(file) as stored:
        arrays = {name: stored[name] for name in stored.files}
    arrays["points/identity"][3] = 7
    np.savez(file, **arrays)
    with pytest.raises(checked_npz.Damaged, match="checksum"):
        checked_npz.read(file)


class Trap:
    def __reduce__(self):
        return os.mkdir, (str(Trap.place),)


def test_a_pickled_object_is_not_unpacked(tmp_path):
    Trap.place = tmp_path / "sprung"
    np.savez(tmp_path / "trap.npz", header=np.array([Trap()], dtype=object))
    with pytest.raises(checked_npz.Damaged):
        checked_npz.read(tmp_path / "trap.npz")
    assert not Trap.place.exists()


# --- which one is taken -----------------------------------------------------------------------------------------------


def test_the_checkpoint_before_a_damaged_one_is_taken_with_a_sentence(left, whole):
    spoil(left / NAME)
    counter = Counter()
    resume(left, extra=(counter,))
    assert counter.records == len((whole / "forces.csv").read_text().splitlines()) - 1 - filling_records(whole)
    assert_same(left, whole)
    (words,) = json.loads((left / "summary.json").read_text())["warnings"]
    assert words.startswith(f"{NAME} is damaged; the run goes on from {PREVIOUS}, at t = 0.")


def test_the_checkpoint_before_a_missing_one_is_taken_too(left):
    (left / NAME).unlink()
    kept, words = checkpoint.latest(left)
    assert kept["simulation"]["clock"]["stage"] == "filling" and words[0].startswith(f"{NAME} is missing")


def filling_records(folder):
    return (folder / "forces.csv").read_text().count(",filling,")


def test_without_a_sound_checkpoint_nothing_is_done(left):
    for name in (NAME, PREVIOUS):
        spoil(left / name)
    before = contents(left)
    with pytest.raises(BadInput, match=f"cannot be resumed: {NAME} is damaged and {PREVIOUS} is damaged"):
        resume(left)
    assert contents(left) == before


def contents(folder):
    return {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.mark.parametrize(("number", "words"), [(99, "is of format 99"), (None, "is of an earlier version")])
def test_a_checkpoint_of_another_format_is_refused(left, number, words):
    with np.load(left / NAME) as stored:
        arrays = {name: stored[name] for name in stored.files}
    header = json.loads(str(arrays["header"])) | {"format": number}
    arrays["header"] = json.dumps(header if number else {"time_s": 0.1})
    np.savez(left / NAME, **arrays)
    with pytest.raises(BadInput, match=f"{NAME} {words}; this version .* goes on from format {checked_npz.FORMAT}"):
        resume(left)


def test_curves_that_are_shorter_than_the_checkpoint_knows_are_refused(left):
    os.truncate(left / "balance.csv", 1000)
    with pytest.raises(BadInput, match=r"balance.csv has 1000 bytes; .* it had written \d+"):
        resume(left)


def test_a_film_that_was_not_begun_is_refused(left):
    with pytest.raises(BadInput, match="film is asked for"):
        resume(left, film=True)


def test_a_disk_that_is_full_costs_a_checkpoint_but_not_the_run(tmp_path, whole, monkeypatch):
    written = []

    def write(file, tree):
        written.append(file)
        file.write_bytes(b"half of it")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(checked_npz, "write", write)
    run(SCENE, tmp_path / "run", film=False)
    assert len(written) == 3, "at the start, after filling, at the end"
    assert not list((tmp_path / "run").glob("checkpoint*"))
    (words,) = json.loads((tmp_path / "run" / "summary.json").read_text())["warnings"]
    assert "checkpoint.npz could not be written (No space left on device)" in words
    assert_same(tmp_path / "run", whole)


def test_a_run_that_was_left_is_neither_overwritten_unasked_nor_forgotten(left):
    with pytest.raises(BadInput, match=rf"--overwrite to replace it, or `taichi-silo resume {left}`$"):
        run(SCENE, left, film=False)


# --- the command ------------------------------------------------------------------------------------------------------


def command(monkeypatch, capsys, *words):
    """Exit code, stdout and stderr of `taichi-silo resume`."""
    monkeypatch.setattr(sys, "argv", ["taichi-silo", "resume", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        app.main()
    return ended.value.code, *(" ".join(text.split()) for text in capsys.readouterr())


def test_the_command_goes_on_and_says_from_where_and_then_that_there_is_nothing_to_do(left, whole, monkeypatch, capsys):
    code, out, err = command(monkeypatch, capsys, left, "--json")
    assert code == 0
    assert "Going on from t = 0." in err and "(flow), u = " in err
    assert json.loads(out)["summary"]["finished"]
    assert_same(left, whole)
    log = (left / "run.log").read_text()
    assert log.count("  begins: ") == 2 and log.count("  goes on (flow, u = ") == 1 and log.endswith("  ends\n")
    assert "ends before its time: stopped at t = 0." in log
    before = contents(left)
    code, out, err = command(monkeypatch, capsys, left)
    assert code == 0 and "is finished; there is nothing to go on with" in out
    assert contents(left) == before


def test_a_folder_without_a_checkpoint_is_refused(tmp_path, monkeypatch, capsys):
    for folder, words in ((tmp_path, "holds no checkpoint to go on from"), (tmp_path / "none", "does not exist")):
        code, out, err = command(monkeypatch, capsys, folder, "--quiet")
        assert (code, out) == (2, "")
        assert err == f"Error: folder is {folder}; it must be that of a run that was begun, but it {words}."
    assert not list(tmp_path.iterdir())


# --- processes --------------------------------------------------------------------------------------------------------


def child(folder):
    scene = SCENE.model_copy(update={"output": Output(checkpoint_s=0.05)})
    words = [sys.executable, "-c", CHILD, scene.model_dump_json(), str(folder)]
    return subprocess.Popen(words, stderr=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)})


def written(folder):
    """When the last checkpoint was."""
    return (folder / NAME).stat().st_mtime_ns if (folder / NAME).exists() else 0


def test_a_run_that_is_killed_and_stopped_again_and_again_loses_nothing(tmp_path, whole):
    folder, rng = tmp_path / "run", random.Random()
    for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL, signal.SIGKILL):
        before, end = written(folder), time.monotonic() + 60.0
        process = child(folder)
        while written(folder) == before:  # then it steps
            assert process.poll() is None and time.monotonic() < end, process.stderr.read()
            time.sleep(0.002)
        time.sleep(rng.uniform(0.0, 0.12))
        process.send_signal(number)
        words = process.communicate(timeout=60)[1]
        assert process.returncode == (-9 if number == signal.SIGKILL else 128 + number), words
        if number != signal.SIGKILL:
            assert words.startswith("Error: stopped at t = 0.")
            assert f"`taichi-silo resume {folder}` goes on from there" in words
        assert "Traceback" not in words
        assert checkpoint.latest(folder)[1] == [], "whatever ends it leaves no damaged checkpoint"
    resume(folder)
    assert_same(folder, whole)
    assert not list(folder.rglob("*part*")) and not (folder / file_lock.NAME).exists()


def test_a_second_run_in_the_same_folder_is_refused_until_the_first_is_gone(left):
    holder = subprocess.Popen(
        [sys.executable, "-c", f"from taichi_silo.utils import file_lock; from pathlib import Path\n"
         f"with file_lock.held(Path({str(left)!r})): print('held', flush=True); input()"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert holder.stdout.readline() == "held\n"
    before = contents(left)
    for attempt in (lambda: resume(left), lambda: run(SCENE, left, overwrite=True, film=False)):
        with pytest.raises(BadInput, match=rf"in use by another run \(process {holder.pid}\)"):
            attempt()
    assert contents(left) == before
    holder.kill()
    holder.wait()
    assert (left / file_lock.NAME).exists(), "what is left of it is in nobody's way"
    with file_lock.held(left):
        pass
    assert not (left / file_lock.NAME).exists()
