"""Whatever befalls the checkpoints of a run, it goes on, or says in a sentence why it cannot."""

import json
import os
import random
import re
import shutil
import sys

import numpy as np
import pytest

from taichi_silo import api
from taichi_silo.cli import app
from taichi_silo.errors import BadInput, Stopped
from taichi_silo.runs.observers import checkpoint
from taichi_silo.runs.observers.checkpoint import NAME, PREVIOUS
from taichi_silo.runs.session import resume, run
from taichi_silo.utils import checked_npz
from tests.faults.harness import At, assert_same, contents, failed, send
from tests.smallest import SMALLEST

pytestmark = pytest.mark.usefixtures("quick")


@pytest.fixture(scope="module")
def stopped(quick, tmp_path_factory):
    """The folder of a run that was stopped in flow; it has two checkpoints, after filling and of the stop."""
    folder = tmp_path_factory.mktemp("runs") / "stopped"
    with pytest.raises(Stopped):
        run(SMALLEST, folder, extra=(At(20, send(), "flow"),))
    assert json.loads((folder / "summary.json").read_text())["failure"].startswith("stopped at t = ")
    return folder


@pytest.fixture
def left(stopped, tmp_path):
    """A copy of that, to be spoiled."""
    return shutil.copytree(stopped, tmp_path / "left")


def spoil(file):
    content = bytearray(file.read_bytes())
    middle = len(content) // 2
    for place in range(middle, middle + 64):  # longer than what no reader looks at, as the time of a member
        content[place] ^= 0xFF
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
    records = []
    resume(left, extra=(At(1, lambda: records.append("first"), "filling"),))
    assert not records, "it is filled already"
    assert_same(left, whole)
    (words,) = json.loads((left / "summary.json").read_text())["warnings"]
    assert words.startswith(f"{NAME} is damaged; the run goes on from {PREVIOUS}, at t = 0.")


def test_the_checkpoint_before_a_missing_one_is_taken_too(left):
    (left / NAME).unlink()
    kept, words = checkpoint.latest(left)
    assert kept["simulation"]["clock"]["stage"] == "filling" and words[0].startswith(f"{NAME} is missing")


def test_without_a_sound_checkpoint_nothing_is_done(left):
    for name in (NAME, PREVIOUS):
        spoil(left / name)
    before = contents(left)
    with pytest.raises(BadInput, match=f"cannot be resumed: {NAME} is damaged and {PREVIOUS} is damaged"):
        resume(left)
    assert contents(left) == before


@pytest.mark.parametrize(("number", "words"), [(99, "is of format 99"), (None, "is of an earlier version")])
def test_a_checkpoint_of_another_format_is_refused(left, number, words):
    with np.load(left / NAME) as stored:
        arrays = {name: stored[name] for name in stored.files}
    header = json.loads(str(arrays["header"])) | {"format": number}
    arrays["header"] = json.dumps(header if number else {"time_s": 0.1})
    np.savez(left / NAME, **arrays)
    with pytest.raises(BadInput, match=f"{NAME} {words}; this version .* goes on from format {checked_npz.FORMAT}"):
        resume(left)


@pytest.mark.parametrize("number", [1])
def test_a_checkpoint_that_an_older_version_wrote_is_refused_clearly(number, tmp_path, data, tried):
    shutil.copy(data / f"checkpoint_format_{number}.npz", tmp_path / NAME)
    before = contents(tmp_path)
    words = rf"is of format {number}; this version of taichi-silo goes on from format {checked_npz.FORMAT}"
    with pytest.raises(BadInput, match=re.escape(words)):
        resume(tmp_path)
    assert contents(tmp_path) == before
    tried("faults survived", "checkpoint of an older version")


def test_curves_that_are_shorter_than_the_checkpoint_knows_are_refused(left):
    os.truncate(left / "balance.csv", 1000)
    with pytest.raises(BadInput, match=r"balance.csv has 1000 bytes; .* it had written \d+"):
        resume(left)


def test_a_film_that_was_not_begun_is_refused(left):
    with pytest.raises(BadInput, match="film is asked for"):
        api.resume(left, film=True)


def test_a_run_that_was_left_is_neither_overwritten_unasked_nor_forgotten(left):
    with pytest.raises(BadInput, match=rf"overwrite=True to replace it, or `ts.resume\('{left}'\)`$") as refused:
        run(SMALLEST, left)
    assert refused.value.on_command_line.endswith(f"--overwrite to replace it, or `taichi-silo resume {left}`")


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_goes_on_and_says_from_where_and_then_that_there_is_nothing_to_do(left, whole, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["taichi-silo", "resume", str(left), "--json"])
    with pytest.raises(SystemExit) as ended:
        app.main()
    out, err = capsys.readouterr()
    assert not ended.value.code and json.loads(out)["summary"]["finished"]
    err = " ".join(err.split())
    assert "Going on from t = 0." in err and "(flow), u = " in err
    assert_same(left, whole)
    log = (left / "run.log").read_text()
    assert log.count("  begins: ") == 2 and log.count("  goes on (flow, u = ") == 1 and log.endswith("  ends\n")
    assert "ends before its time: stopped at t = 0." in log
    before = contents(left)
    monkeypatch.setattr(sys, "argv", ["taichi-silo", "resume", str(left)])
    with pytest.raises(SystemExit):
        app.main()
    assert "is finished; there is nothing to go on with" in " ".join(capsys.readouterr().out.split())
    assert contents(left) == before


def test_a_folder_without_a_checkpoint_is_refused(tmp_path, monkeypatch, capsys):
    for folder, words in ((tmp_path, "holds no checkpoint to go on from"), (tmp_path / "none", "does not exist")):
        code, err = failed(monkeypatch, capsys, "resume", folder, "--quiet")
        assert code == 2
        assert err == f"Error: folder is {folder}; it must be that of a run that was begun, but it {words}."
    assert not list(tmp_path.iterdir())
