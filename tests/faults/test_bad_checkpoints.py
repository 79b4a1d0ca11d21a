"""Checkpoints that are none, or were made to harm: refused in a sentence, and no name in them leads anywhere."""

import contextlib
import io
import json
import os
import resource
import time
import zipfile

import numpy as np
import pytest

from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs.observers.checkpoint import NAME, PREVIOUS
from taichi_silo.runs.session import resume
from taichi_silo.utils import checked_npz
from tests.faults.bad import ROOM_KB, SECONDS, broken_link, folder, pipe, refusal, zeros
from tests.faults.harness import contents

RNG = np.random.default_rng(5)


TREE = {"clock": {"time": 0.1}, "points": {"position": np.zeros((50, 2)), "mass": np.ones(50)}}


def npy(values="<f8", shape=(3,), data=b"\0" * 24):
    """A member in numpy's form, which may say more than it holds."""
    header = repr({"descr": values, "fortran_order": False, "shape": shape}).encode()
    header += b" " * (64 - (len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + data


def zipped(members, packed=False):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED) as file:
        for name, data in members.items():
            file.writestr(name, data)
    return stream.getvalue()


def words(text):
    stream = io.BytesIO()
    np.save(stream, np.array(text))
    return stream.getvalue()


def crafted(tree):
    """A checkpoint with a valid checksum."""
    file = io.BytesIO()
    arrays = {}
    content = json.dumps(checked_npz._without_arrays(tree, "", arrays), default=lambda value: value.item())
    header = {"format": checked_npz.FORMAT, "taichi_silo": "0", "sha256": checked_npz._checksum(content, arrays)}
    np.savez(file, header=json.dumps(header), content=content, **arrays)
    return file.getvalue()


GOOD = {"header.npy": words(json.dumps({"format": checked_npz.FORMAT, "sha256": ""})), "content.npy": words("{}")}
ARCHIVES = {
    "nothing": b"",
    "noise": RNG.bytes(5000),
    "a zip": zipped({"a.txt": b"hello"}),
    "an empty zip": zipped({}),
    "another program's": zipped({"arr_0.npy": words("a")}),
    "text": b"checkpoint",
    "a pickle": b"\x80\x04N.",
    "packed zeros": zipped({**GOOD, "x.npy": b"\0" * 300_000_000}, packed=True),
    "more than there is": zipped({**GOOD, "x.npy": npy(shape=(10**12,))}),
    "a word of 10^12 letters": zipped({**GOOD, "x.npy": npy("<U1000000000", ())}),
    "a negative size": zipped({**GOOD, "x.npy": npy(shape=(-3,))}),
    "more than counts": zipped({**GOOD, "x.npy": npy(shape=(2**62, 4))}),
    "an object": zipped({**GOOD, "x.npy": npy("|O", (1,), b"\x80\x04N.")}),
    "a form of its own": zipped({**GOOD, "x.npy": npy([("a", "|O")], (1,))}),
    "code for a shape": zipped({**GOOD, "x.npy": npy(shape=(3,)).replace(b"(3,)", b"f(3)")}),
    "a header that is none": zipped({"header.npy": words("[1, 2"), "content.npy": words("{}")}),
    "a header that is a number": zipped({"header.npy": words("3"), "content.npy": words("{}")}),
    "a deep header": zipped({"header.npy": words("[" * 100_000), "content.npy": words("{}")}),
    "a deep content": crafted({"x": 1}).replace(b"x", b"["),
    "no content": zipped({"header.npy": GOOD["header.npy"]}),
    "names that lead nowhere": crafted({"a": {"b": np.zeros(2)}}).replace(b"a/b.npy", b"c/d.npy"),
}


def test_foreign_and_crafted_checkpoints_are_damaged_and_run_no_code(tmp_path, tried):
    file = tmp_path / NAME
    for kind, data in ARCHIVES.items():
        file.write_bytes(data)
        begun, room = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with pytest.raises((checked_npz.Damaged, BadInput)):
            checked_npz.read(file)
        assert time.monotonic() - begun < SECONDS, kind
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - room < ROOM_KB, kind
        words = refusal(lambda: resume(tmp_path))
        assert words is not None, kind
        assert [one.name for one in tmp_path.iterdir()] == [NAME], kind
    tried("inputs refused", "a checkpoint that is none", len(ARCHIVES))


@pytest.mark.skipif(os.name == "nt", reason="pipes, devices and links of Unix")
def test_a_checkpoint_that_is_no_file_is_refused(tmp_path, tried):
    for kind, make in (("a folder", folder), ("a pipe", pipe), ("a device", zeros), ("a link to nothing", broken_link)):
        place = tmp_path / kind
        place.mkdir()
        make(place / NAME)
        assert refusal(lambda place=place: resume(place)) is not None, kind
    tried("inputs refused", "a checkpoint that is none", 4)


def test_a_checkpoint_of_another_run_is_refused(left, tried):
    header, kept = checked_npz.read(left / NAME)
    kept["scene"]["flow"]["displacement_m"] = 0.01
    (left / NAME).write_bytes(crafted(kept))
    before = contents(left)
    assert "checkpoint is of another run, with flow.displacement_m = 0.01 instead of 0.006" in refusal(
        lambda: resume(left)
    )
    assert contents(left) == before
    tried("inputs refused", "a checkpoint of another run")


SPOILS = {
    "no clock": lambda kept: kept["simulation"].pop("clock"),
    "no time": lambda kept: kept["simulation"]["clock"].pop("time"),
    "no scene": lambda kept: kept.pop("scene"),
    "a scene that is none": lambda kept: kept.update(scene=3),
    "a scene that is impossible": lambda kept: kept["scene"]["silo"].update(width_m=-1),
    "no simulation": lambda kept: kept.pop("simulation"),
    "no observers": lambda kept: kept.pop("observers"),
    "observers that are a list": lambda kept: kept.update(observers=[]),
    "no run": lambda kept: kept.pop("run"),
}


@pytest.mark.parametrize("kind", SPOILS)
def test_a_checkpoint_that_is_whole_but_holds_something_else_is_refused(kind, left, tried):
    header, kept = checked_npz.read(left / NAME)
    SPOILS[kind](kept)
    for name in (NAME, PREVIOUS):
        (left / name).write_bytes(crafted(kept))
    before = contents(left)
    assert refusal(lambda: resume(left)) is not None
    assert contents(left) == before
    tried("inputs refused", "a checkpoint that holds something else")


def test_names_in_a_checkpoint_never_lead_out_of_its_folder(left, tmp_path, tried):
    (tmp_path / "precious.vtu").write_bytes(b"precious")
    names = ["../../precious.vtu", str(tmp_path / "precious.vtu"), "..", ".", "", "run.toml"]
    header, kept = checked_npz.read(left / NAME)
    for name in names:
        row = {"file": name, "stage": "x", "time_s": 0, "displacement_m": 0}
        kept["observers"]["snapshots"]["rows"] = [row]
        (left / NAME).write_bytes(crafted(kept))
        with contextlib.suppress(BadInput, RunFailed):
            resume(left)
        assert (tmp_path / "precious.vtu").read_bytes() == b"precious"
        assert sorted(one.name for one in tmp_path.iterdir()) == ["left", "precious.vtu"]
        assert (left / "run.toml").exists()
    tried("inputs refused", "a checkpoint whose names lead out of its folder", len(names))
