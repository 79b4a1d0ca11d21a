"""What befalls a run of the smallest silo, and what must be left of it."""

import codecs
import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import meshio
import numpy as np
import pytest

from taichi_silo.cli import app
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers import Observer, checkpoint
from taichi_silo.utils import checked_npz
from tests.smallest import SMALLEST

ROOT = Path(__file__).parents[2]
OWN = ("run.toml", "run.log", "summary.json", "checkpoint.npz", "checkpoint.previous.npz")

# --- what befalls it --------------------------------------------------------------------------------------------------


class At(Observer):
    """Does something after so many records, of a stage if one is named, and `at_end` when the run ends."""

    def __init__(self, records, do, stage=None, at_end=lambda: None):
        self.left, self.do, self.stage, self.at_end = records, do, stage, at_end

    def begin(self, simulation):
        self.simulation = simulation

    def observe(self, record):
        counts = self.stage in (None, record.stage)
        self.left -= counts
        if counts and self.left == 0:
            self.do()

    def end(self):
        self.at_end()


def send(number=signal.SIGINT, times=1):
    """A function that sends this process a signal; Python hears it between two of its instructions."""

    def do():
        for _ in range(times):
            os.kill(os.getpid(), number)
            time.sleep(0)

    return do


def child(folder, scene=SMALLEST, **how):
    """A process that begins the run of a folder, or goes on with it (child.py)."""
    given = json.dumps({"scene": scene.model_dump(mode="json"), "folder": str(folder)} | how)
    command = [sys.executable, "-m", "tests.faults.child", given]
    return subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)}
    )


@contextlib.contextmanager
def files_end_at(size: int):
    """Within, no file grows beyond so many bytes: EFBIG, after what still fits was written."""
    resource = pytest.importorskip("resource")  # Windows has no such limit
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, usual[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)


class Disk:
    """A file system in memory."""

    def __init__(self, place: Path, size: int):
        self.place = place
        place.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "silo", place], capture_output=True)
        if done.returncode:
            pytest.skip("it takes the right to mount a file system")

    def become(self, *options: str) -> None:
        subprocess.run(["mount", "-o", f"remount,{','.join(options)}", self.place], check=True)

    def __enter__(self) -> "Disk":
        return self

    def __exit__(self, *_) -> None:
        subprocess.run(["umount", "-l", self.place], check=True)


@contextlib.contextmanager
def nobody():
    """Within, this process has no more rights to files than any user."""
    if not hasattr(os, "geteuid"):
        pytest.skip("Windows keeps rights in other ways")
    codecs.lookup("utf-8-sig")  # which scenes are read with; Python's own files may lie where nobody can read
    own = os.geteuid()
    if own == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        if own == 0:
            os.seteuid(0)


def command(patch, capsys, *words):
    """Exit code and stderr of `taichi-silo`; no traceback."""
    capsys.readouterr()
    patch.setattr(sys, "argv", ["taichi-silo", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        app.main()
    err = capsys.readouterr().err
    assert "Traceback" not in err
    return ended.value.code, err


def failed(patch, capsys, *words):
    """Exit code and last sentence, on one line, of a command that fails."""
    code, err = command(patch, capsys, *words)
    err = " ".join(err.split())
    return code, err[err.rfind("Error: ") :]


# --- what is left of it -----------------------------------------------------------------------------------------------


def contents(folder: Path) -> dict[str, bytes | str]:
    """What there is below a folder, by name: bytes, or where a link leads."""
    return {
        file.relative_to(folder).as_posix(): os.readlink(file) if file.is_symlink() else file.read_bytes()
        for file in folder.rglob("*")
        if file.is_symlink() or file.is_file()
    }


def assert_same(folder: Path, whole: Path, but: tuple = ()) -> None:
    """The run is, bit by bit, the one that nothing befell; only clocks, warnings and `but` differ."""
    found, wanted = ({k: v for k, v in contents(place).items() if k not in but} for place in (folder, whole))
    assert found.keys() == wanted.keys()
    assert not [name for name in found if ".part" in name or "segment" in name or name.startswith(".")]
    assert [name for name in found if name not in OWN and found[name] != wanted[name]] == []
    summaries = [json.loads((place / "summary.json").read_text()) for place in (folder, whole)]
    for summary in summaries:
        assert summary["finished"]
        for clock in ("seconds", "wall_seconds", "particle_steps_per_second"):
            del summary["cost"][clock]
        summary.pop("warnings", None)
    assert summaries[0] == summaries[1]


def assert_sound(folder: Path, whole: Path) -> None:
    """Nothing is lost of what a run that was cut off had reported as written."""
    rows, all_rows = (place.joinpath("forces.csv").read_bytes() for place in (folder, whole))
    if checkpoint.is_there(folder):
        kept, words = checkpoint.latest(folder)
        assert not words or words[0].startswith("checkpoint.npz is missing"), words
        known = kept["observers"]["forces"]["bytes"]
        assert len(rows) >= known and rows[:known] == all_rows[:known]
    assert all_rows.startswith(rows[: rows.rfind(b"\n") + 1])
    assert_readable(folder)


def assert_readable(folder: Path) -> None:
    """Every file that bears its own name is whole."""
    if (folder / "snapshots" / "index.csv").exists():
        with open(folder / "snapshots" / "index.csv", encoding="utf-8") as stream:
            for row in csv.DictReader(stream):
                snapshot.read(folder / "snapshots" / row["file"])
    for file in folder.glob("checkpoint*.npz"):
        checked_npz.read(file)
    if (folder / "summary.json").exists():
        json.loads((folder / "summary.json").read_text())
    for file in folder.rglob("*.png"):
        assert file.read_bytes().endswith(b"IEND\xaeB`\x82"), file


def assert_finite(folder: Path) -> None:
    """No file of a run holds a number that is none, except where a profile has no value by its nature."""
    for file in folder.rglob("*"):
        if file.suffix in (".json", ".toml", ".csv"):
            words = file.read_text().lower().replace(",", " ").replace(":", " ").split()
            assert not {"nan", "-nan", "inf", "-inf", "infinity"} & set(words), file
        if file.suffix == ".vtu":
            mesh = meshio.read(file)
            assert np.isfinite(mesh.points).all(), file
            assert all(np.isfinite(values).all() for values in mesh.point_data.values()), file
        if file.suffix == ".npz":
            with np.load(file) as state:
                numbers = [state[name] for name in state.files if state[name].dtype.kind == "f"]
            assert all(np.isfinite(values).all() for values in numbers), file
