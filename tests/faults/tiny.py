"""The run that faults befall: 32 points, a second of stepping, every kind of file; and what must be left of it."""

import csv
import json
from pathlib import Path

from taichi_silo import Flow, Machine, Mesh, Method, Scene, Silo
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers import checkpoint
from taichi_silo.scene.scene import Output
from taichi_silo.utils import checked_npz

ROOT = Path(__file__).parents[2]
SCENE = Scene(
    silo=Silo(height_m=0.4), grid=Mesh(cell_size_m=0.05), flow=Flow(speed_m_per_s=0.04, displacement_m=0.006),
    method=Method(filling_time_s=0.1, longest_settling_s=0.0), machine=Machine(threads=1, lanes=False),
    output=Output(snapshots=12, records_per_period=4),
)  # fmt: skip
OWN = ("run.toml", "run.log", "summary.json", "checkpoint.npz", "checkpoint.previous.npz", "void_ratio.mp4")


def files(folder: Path) -> set[str]:
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}


def assert_same(folder: Path, whole: Path, but: tuple = ()) -> None:
    """The run is, bit by bit, the one that nothing befell; only clocks, warnings and `but` differ."""
    found = files(folder)
    assert found - set(but) == files(whole) - set(but)
    assert not [name for name in found if ".part" in name or "segment" in name or name.startswith(".")]
    for name in found - {*OWN, *but}:
        assert (folder / name).read_bytes() == (whole / name).read_bytes(), name
    summaries = [json.loads((place / "summary.json").read_text()) for place in (folder, whole)]
    for summary in summaries:
        assert summary["finished"]
        summary["cost"] = summary["cost"]["steps"]
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
