"""A disk that is full, at each kind of write: one sentence, nothing half-written, and the run goes on afterwards."""

import contextlib
import json
import shutil
from fnmatch import fnmatch

import pandas as pd
import pytest

from taichi_silo import api
from taichi_silo.errors import MachineFailed
from taichi_silo.runs.observers import checkpoint, film_recorder
from taichi_silo.runs.session import resume, run
from taichi_silo.show import figures, run_end
from taichi_silo.studies.sweep import table
from taichi_silo.utils import atomic_write
from taichi_silo.utils.appended_file import AppendedFile
from tests import made_up
from tests.faults.harness import Disk, assert_readable, assert_same, assert_sound, contents, failed, files_end_at
from tests.smallest import SMALLEST

FULL = "cannot be written: File too large; raise the limit of a file's size"
MIDWAY = ("forces.csv", "balance.csv", "film_*.vtu", "index.csv")  # while it fills and flows, in this order
AT_THE_END = ("walls.csv", "summary.json", "forces.png", "run.toml")


@pytest.fixture(autouse=True, scope="module")
def one_figure(quick):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "RUN_FIGURES", {"forces": figures.RUN_FIGURES["forces"]})
        yield


@contextlib.contextmanager
def full_at(pattern, after=0):
    """Within, files of such a name take no more than some bytes, once so many of them were written."""
    written, append, count = atomic_write.written, AppendedFile.append, 0

    def due(file):
        nonlocal count
        count += fnmatch(file.name, pattern)
        return fnmatch(file.name, pattern) and count > after

    @contextlib.contextmanager
    def limited(file, previous=None):
        with files_end_at(100) if due(file) else contextlib.nullcontext(), written(file, previous) as passing:
            yield passing

    def row(self, piece):
        with files_end_at(self.size + 30) if due(self.file) else contextlib.nullcontext():
            append(self, piece)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(atomic_write, "written", limited)
        patch.setattr(AppendedFile, "append", row)
        yield


def test_every_file_of_a_run_may_find_the_disk_full(tmp_path, whole, monkeypatch, capsys, tried):
    folder = tmp_path / "run"
    with full_at(MIDWAY[0], after=15), pytest.raises(MachineFailed, match=f"^stopped at t = .*forces.csv {FULL}, then"):
        run(SMALLEST, folder)
    for pattern, after in [*((name, 4) for name in MIDWAY[1:]), *((name, 0) for name in AT_THE_END)]:
        assert not [name for name in contents(folder) if ".part" in name]
        assert_sound(folder, whole)
        assert (folder / "forces.csv").read_bytes().endswith(b"\n")
        monkeypatch.setattr(api, "DRAWING", (run_end.draw_figures,) if pattern.endswith(".png") else ())
        after = 1 if pattern == "run.toml" else after
        with full_at(pattern, after):
            code, err = failed(monkeypatch, capsys, "resume", folder, "--quiet")
        assert code == 1
        assert err.startswith("Error: stopped at t = 0.") and err.count(". ") == 0
        assert err.endswith(f"{FULL}, then `taichi-silo resume {folder}` goes on from its last checkpoint.")
        assert fnmatch(err.split(" cannot be written")[0].split("/")[-1], pattern)
    shutil.rmtree(folder / "figures")
    resume(folder)
    assert_same(folder, whole)
    tried("faults survived", "disk full while a file of a run is written", len(MIDWAY) + len(AT_THE_END))


def test_without_room_for_a_checkpoint_the_run_ends_and_without_any_it_begins_again(tmp_path, whole, tried):
    folder = tmp_path / "run"
    with full_at("checkpoint.npz"):
        run(SMALLEST, folder)
    (words,) = json.loads((folder / "summary.json").read_text())["warnings"]
    assert words.startswith(f"{folder / 'checkpoint.npz'} could not be written (File too large)")
    assert not checkpoint.is_there(folder)
    assert_same(folder, whole, but=("checkpoint.npz", "checkpoint.previous.npz"))
    with files_end_at(1000), pytest.raises(MachineFailed, match="then begin again$"):
        run(SMALLEST, tmp_path / "second")
    tried("faults survived", "disk full while a checkpoint is written", 2)


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    folder = made_up.leave(tmp_path_factory.mktemp("left") / "run", states=12)
    figures.plot_run(folder)
    shutil.copytree(folder, folder.with_name("other"))
    return folder


@pytest.mark.parametrize(
    "words",
    [
        ("report", "{run}", "--output", "{out}/page.html"),
        ("export", "{run}", "--output", "{out}/a.vtkhdf"),
        ("export", "{run}", "--format", "csv", "--output", "{out}/tables"),
        ("render", "{run}", "--frame", "10", "--size", "320x180", "--output", "{out}/a.png"),
        ("render", "{run}", "--seconds", "0.5", "--size", "320x180", "--output", "{out}/a.mp4"),
        ("compare", "{run}", "{run}/../other", "--output", "{out}"),
        ("gallery", "{run}", "--output", "{out}"),
    ],
    ids=lambda words: words[0] + words[-1].rpartition("}")[2],
)  # fmt: skip
def test_other_commands_say_so_and_leave_what_was_there(words, left, tmp_path, monkeypatch, capsys, tried):
    before = contents(left)
    out = tmp_path / "out"
    with files_end_at(500):
        code, err = failed(monkeypatch, capsys, *(word.format(run=left, out=out) for word in words), "--quiet")
    assert code == 1 and err.startswith(f"Error: {out}"), err
    assert "File too large" in err or "ffmpeg" in err
    assert err.endswith(", and give the command again.")
    assert not out.exists() or not contents(out)
    assert contents(left) == before
    tried("faults survived", "disk full while a command writes")


def test_the_table_of_a_sweep_stays_as_it_was(tmp_path, tried):
    file = tmp_path / "sweep.csv"
    rows = [{"run": f"run-{number}", "P": 1.0 / 3.0} for number in range(50)]
    table.leave(file, rows[:3])
    before = file.read_bytes()
    with files_end_at(200), pytest.raises(OSError, match="File too large.*sweep.csv"):
        table.leave(file, rows)
    assert contents(tmp_path) == {"sweep.csv": before}
    tried("faults survived", "disk full while a command writes")


@pytest.mark.long
@pytest.mark.parametrize("film", [False, True], ids=["no film", "film"])
def test_a_small_disk_that_is_full_sooner_or_later(film, tmp_path, whole, monkeypatch, tried):
    """The space ends at twenty different amounts; afterwards there is more."""
    monkeypatch.setitem(film_recorder.FRAMES, "filling", 4)
    monkeypatch.setitem(film_recorder.FRAMES, "flow", 8)
    monkeypatch.setattr(api, "DRAWING", (run_end.draw_film,))
    with_film = api.run(SMALLEST, tmp_path / "whole", film=film, progress=False).folder
    needed, ends = sum(map(len, contents(with_film).values())), 0
    for part in range(1, 11 if film else 21):
        size = int(needed * part / (11 if film else 21)) // 4096 * 4096
        with Disk(tmp_path / f"disk-{part}", size) as disk:
            folder = disk.place / "run"
            try:
                api.run(SMALLEST, folder, film=film, progress=False)
                told = (folder / "summary.json").read_text()
                assert "could not be written (No space left" in told or "The film is not drawn" in told
            except MachineFailed as error:
                ends += 1
                assert "No space left on device; free some space, then " in str(error)
            assert_readable(folder)
            for name in ("forces.csv", "balance.csv"):
                assert pd.read_csv(folder / name).notna().all(axis=None)
            disk.become("size=100m")
            noted = (folder / "run.toml").read_text() if (folder / "run.toml").exists() else ""
            but = ("void_ratio.mp4",) * ("finished = true" in noted and not (folder / "void_ratio.mp4").exists())
            but += ("checkpoint.npz", "checkpoint.previous.npz") * ("finished = true" in noted)
            if checkpoint.is_there(folder):
                api.resume(folder, progress=False)
            else:
                api.run(SMALLEST, folder, film=film, overwrite=True, progress=False)
            assert_same(folder, with_film, but)
    assert ends > 5
    tried("faults survived", "disk full at an amount of its own", ends)
