"""Whatever links, pipes and names lie in a folder: nothing is written, cut off or removed outside of it."""

import io
import os
import shutil
from pathlib import Path

import pytest
from PIL import Image

from taichi_silo import api
from taichi_silo.runs.run_folder import named, own
from taichi_silo.runs.session import resume, run
from taichi_silo.studies.sweep.plan import Sweep
from taichi_silo.studies.sweep.study import Study
from taichi_silo.utils.console import Console
from tests.faults.bad import refusal, refused
from tests.faults.harness import command, contents
from tests.smallest import SMALLEST

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links need rights of their own on Windows")
FILES = (
    "run.toml", "forces.csv", "balance.csv", "walls.csv", "summary.json", "checkpoint.npz", "checkpoint.previous.npz",
    "checkpoint.part.npz", ".lock", "run.toml.part", "report.html", "report.html.part", "void_ratio.mp4",
    "void_ratio.segment_0000.mp4", "void_ratio.partial.mp4", "silo.vtkhdf", "silo.vtkhdf.part", "figures/forces.png",
    "snapshots/index.csv", "snapshots/index.csv.part", "snapshots/start.vtu", "snapshots/silo.pvd",
)  # fmt: skip
FOLDERS = ("figures", "snapshots", "csv")


@pytest.fixture
def outside(tmp_path):
    """What must stay as it is: a file, and a folder with files of a run's names."""
    place = tmp_path / "outside"
    (place / "folder").mkdir(parents=True)
    (place / "file").write_text("precious")
    for name in ("start.vtu", "index.csv", "forces.png", "void_ratio.png", "a.csv"):
        (place / "folder" / name).write_text("precious")
    return place


def linked(place, name, outside):
    """A link of this name in place of what is there, to something outside."""
    link = place / name
    link.parent.mkdir(parents=True, exist_ok=True)
    if link.is_dir() and not link.is_symlink():
        shutil.rmtree(link)
    link.unlink(missing_ok=True)
    link.symlink_to(outside / ("folder" if name in FOLDERS else "file"))
    return link


@pytest.mark.parametrize("name", [*FILES, *FOLDERS])
def test_a_link_in_the_folder_of_a_run_is_refused(name, left, outside, tried):
    link, before = linked(left, name, outside), contents(outside)
    words = refusal(lambda: own(left))
    assert words is not None and str(link) in words and "is a link" in words
    assert contents(outside) == before
    tried("inputs refused", "a link in the folder of a run")


@pytest.mark.parametrize("name", ["forces.csv", ".lock", "snapshots", "figures", "checkpoint.npz", "run.toml"])
def test_neither_a_run_nor_its_resumption_writes_through_a_link(name, left, outside, tried):
    link, before = linked(left, name, outside), contents(outside)
    inside = contents(left)
    for attempt in (lambda: run(SMALLEST, left, overwrite=True), lambda: resume(left)):
        words = refusal(attempt)
        assert words is not None and str(link) in words and "is a link" in words
    assert contents(outside) == before and contents(left) == inside
    tried("inputs refused", "a link in the folder of a run", 2)


def test_a_link_to_nothing_is_not_written_through_either(left, outside):
    (left / "balance.csv").unlink()
    (left / "balance.csv").symlink_to(outside / "new")
    assert "is a link" in refusal(lambda: resume(left))
    assert not (outside / "new").exists()


def test_a_pipe_or_a_file_in_the_place_of_a_folder_is_refused(left, tried):
    os.mkfifo(left / "curve.csv")
    assert "no file or folder" in refusal(lambda: run(SMALLEST, left, overwrite=True))
    (left / "curve.csv").unlink()
    shutil.rmtree(left / "snapshots")
    (left / "snapshots").write_text("")
    assert "must be a folder" in refusal(lambda: resume(left))
    tried("inputs refused", "a link in the folder of a run", 2)


def test_the_folder_itself_may_be_a_link(tmp_path, outside):
    (tmp_path / "run").symlink_to(outside / "folder")
    assert own(tmp_path / "run") == tmp_path / "run"


def picture():
    stream = io.BytesIO()
    Image.new("RGB", (4, 4)).save(stream, "PNG")
    return stream.getvalue()


def writers(place, out):
    """Commands that write, each with the names in `out` that are links when it begins."""
    yield ("report", place, "--output", out / "page.html"), ("page.html", "page.html.part")
    yield (
        ("render", place, "--frame", "1", "--size", "320x180", "--output", out / "one.png", "--overwrite"),
        ("one.png", "one.png.part"),
    )
    yield (
        ("render", place, "--size", "320x180", "--output", out / "a.mp4", "--overwrite"),
        ("a.mp4", "a.part.mp4"),
    )
    yield ("export", place, "--output", out / "b.vtkhdf", "--overwrite"), ("b.vtkhdf", "b.vtkhdf.part")
    yield ("export", place, "--format", "csv", "--output", out / "csv", "--overwrite"), ("csv", "csv.part")
    yield ("compare", place, "--janssen", "--output", out), ("compare.csv", "compare.csv.part", "compare_forces.png")
    yield ("gallery", place, "--output", out), ("index.html", "index.html.part")


def test_no_command_writes_through_a_link(left, tmp_path, outside, monkeypatch, capsys, tried):
    before, inside, count = contents(outside), contents(left), 0
    for number, (words, names) in enumerate(writers(left, tmp_path / "out")):
        for name in names:
            out = tmp_path / "out"
            out.mkdir()
            linked(out, name, outside)
            (left / "figures").mkdir(exist_ok=True)
            (left / "figures" / "forces.png").write_bytes(picture())
            assert "is a link" in refused(monkeypatch, capsys, *words), (number, name)
            assert contents(outside) == before
            assert [one.name for one in out.iterdir()] == [name]
            shutil.rmtree(out)
            count += 1
    shutil.rmtree(left / "figures")
    assert contents(left) == inside
    tried("inputs refused", "a link in the place of an output", count)


def test_a_report_into_the_folder_of_a_run_draws_through_no_link(left, outside, monkeypatch, capsys, tried):
    before = contents(outside)
    for name in ("figures", "figures/forces.png", "report.html"):
        linked(left, name, outside)
        (left / "summary.json").unlink(missing_ok=True)
        assert "is a link" in refused(monkeypatch, capsys, "report", left)
        assert contents(outside) == before
        (left / name).unlink()
        shutil.rmtree(left / "figures", ignore_errors=True)
    tried("inputs refused", "a link in the place of an output", 3)


def test_a_sweep_writes_through_no_link(tmp_path, outside, tried):
    before, plan = contents(outside), Sweep(grid={"walls.kind": ("very-rough",)})
    (name,) = plan.scenes()
    for link in ("sweep.csv", "sweep.csv.part", ".sweep", "figures", "figures/forces.png", f"{name}/forces.csv"):
        place = tmp_path / "sweep"
        linked(place, link, outside)
        assert "is a link" in refusal(lambda place=place: Study(plan, place, Console(quiet=True)).run())
        assert contents(outside) == before
        shutil.rmtree(place)
    tried("inputs refused", "a link in the folder of a sweep", 6)


@pytest.mark.parametrize(
    ("file", "name"),
    [("...toml", "run"), ("..toml", "run"), (".hidden.toml", "hidden"), ("a.toml", "a"), ("a b.toml", "a b"),
     ("a\nb.toml", "ab"), ("\u202ea.toml", "a"), ("/run.toml", "run"), ("/x/run.toml", "x"), ("-rf.toml", "-rf")],
)  # fmt: skip
def test_a_scene_file_gives_its_run_a_name_that_stays_in_the_output(file, name):
    assert named(Path(file)) == name


def test_a_scene_called_by_the_parent_folder_does_not_run_there(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "...toml").write_text("[flow]\nspeed_m_per_s = -1\n")
    refused(monkeypatch, capsys, "run", "./...toml")
    assert [one.name for one in tmp_path.iterdir()] == ["...toml"]


@pytest.mark.parametrize("output", ["file/run", "/dev/null/run", "/proc/run", "x" * 300, "~nobody-of-this-name/run"])
def test_an_output_where_nothing_can_be_written_is_refused(output, tmp_path, monkeypatch, tried):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    assert refusal(lambda: api.run(SMALLEST, output, progress=False)) is not None
    assert [one.name for one in tmp_path.iterdir()] == ["file"]
    tried("inputs refused", "an output where nothing can be written")


def test_commands_refuse_outputs_where_nothing_can_be_written(left, tmp_path, monkeypatch, capsys, tried):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.chdir(tmp_path)
    before, count = contents(tmp_path), 0
    for output in (tmp_path / "file" / "x", Path("x" * 300) / "y"):
        for words in (
            ("report", left, "--output", output.with_suffix(".html")), ("export", left, "--output", output),
            ("export", left, "--format", "csv", "--output", output), ("compare", left, "--janssen", "--output", output),
            ("render", left, "--frame", "0", "--output", output.with_suffix(".png")), ("scene", "--output", output),
        ):  # fmt: skip
            code, err = command(monkeypatch, capsys, *words)
            assert code == 2 and err.count("\n") == 1, (words, err)
            count += 1
    assert contents(tmp_path) == before
    tried("inputs refused", "an output where nothing can be written", count)
