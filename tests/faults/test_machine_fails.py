"""Folders that vanish, clocks that jump, an ffmpeg that dies, too little memory: a run says so, or goes on."""

import contextlib
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest

from taichi_silo import api
from taichi_silo.errors import BadInput, MachineFailed
from taichi_silo.runs import film_states
from taichi_silo.runs.observers import film_recorder
from taichi_silo.runs.session import resume, run
from taichi_silo.scene import memory_need
from taichi_silo.scene.scene import Averaging, Mesh
from taichi_silo.show.film import FilmError, encoder
from taichi_silo.show.run_end import draw_film
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.appended_file import AppendedFile
from tests.faults.harness import (
    ROOT,
    At,
    Disk,
    assert_readable,
    assert_same,
    assert_sound,
    contents,
    failed,
    files_end_at,
    nobody,
    send,
)
from tests.smallest import SMALLEST, smallest

OFTEN = smallest(output={"checkpoint_s": 0.02})
FRAMES = (4, 8)


@pytest.fixture(autouse=True, scope="module")
def short_films(quick):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(film_recorder.FRAMES, "filling", FRAMES[0])
        patch.setitem(film_recorder.FRAMES, "flow", FRAMES[1])
        yield


def test_a_folder_that_is_removed_ends_the_run_soon_and_is_not_made_again(tmp_path, tried):
    folder = tmp_path / "run"
    with pytest.raises(MachineFailed, match=f"because the folder {folder} was gone, and .*; if it was removed, begin"):
        run(OFTEN, folder, extra=(At(20, lambda: shutil.rmtree(folder)),))
    assert not folder.exists()
    tried("faults survived", "output folder removed midway")


def test_a_folder_that_is_moved_goes_on_under_its_new_name(tmp_path, whole, tried):
    folder, moved = tmp_path / "run", tmp_path / "moved"
    with pytest.raises(MachineFailed, match=f"the folder {folder} was gone"):
        run(OFTEN, folder, extra=(At(30, lambda: folder.rename(moved)),))
    assert_sound(moved, whole)
    resume(moved)
    assert_same(moved, whole)
    tried("faults survived", "output folder moved midway")


def test_curves_that_are_removed_while_they_are_written_are_missed(tmp_path, tried):
    folder = tmp_path / "run"
    with pytest.raises(MachineFailed, match=r"forces.csv cannot be written: it has been removed; put it back"):
        run(OFTEN, folder, extra=(At(20, (folder / "forces.csv").unlink),))
    assert_readable(folder)
    tried("faults survived", "a file removed midway")


def test_a_folder_that_may_not_be_written_any_more_keeps_what_it_has(whole, monkeypatch, capsys, tried):
    place = Path(tempfile.mkdtemp())  # which others than its owner may enter
    place.chmod(0o755)
    folder, rights = place / "run", contextlib.ExitStack()

    def let(mode):
        for inner in (folder, folder / "snapshots"):
            inner.chmod(mode)

    def close():
        let(0o555)
        rights.enter_context(nobody())

    try:
        with pytest.raises(MachineFailed, match="written: Permission denied; let it be written to, then "), rights:
            run(SMALLEST, folder, extra=(At(20, close),))
        assert_sound(folder, whole)
        with nobody():
            code, err = failed(monkeypatch, capsys, "resume", folder, "--quiet")
            assert (code, err) == (2, f"Error: output {folder} cannot be written: Permission denied.")
        let(0o755)
        resume(folder)
        assert_same(folder, whole)
    finally:
        shutil.rmtree(place)
    tried("faults survived", "output folder made read-only midway")


@pytest.mark.long
def test_a_file_system_that_becomes_read_only_keeps_what_it_has(tmp_path, whole, tried):
    with Disk(tmp_path / "disk", 1 << 26) as disk:
        folder = run(SMALLEST, disk.place / "run")
        (folder / "run.toml").write_text((folder / "run.toml").read_text().replace("finished = true", ""))
        before = contents(folder)
        disk.become("ro")
        with pytest.raises(BadInput, match="cannot be written: Read-only file system"):
            resume(folder)
        assert contents(folder) == before
        disk.become("rw")
        resume(folder)
        assert_same(folder, whole)
    tried("faults survived", "file system read-only")


def test_a_clock_that_jumps_changes_nothing(tmp_path, whole, monkeypatch, tried):
    now, jumps = time.time, [7200.0, -90000.0, 1e9]

    def jump():
        by = jumps.pop()
        monkeypatch.setattr(time, "time", lambda: now() + by)

    run(SMALLEST, tmp_path / "run", extra=tuple(At(number, jump) for number in (5, 30, 50)))
    assert not jumps
    assert_same(tmp_path / "run", whole)
    tried("faults survived", "clock set forward or back by hours", 3)


# --- the film ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def filmed(quick, tmp_path_factory):
    """The folder of a run with its film that nothing befell."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(api, "DRAWING", (draw_film,))
        return film(tmp_path_factory.mktemp("runs") / "filmed")


@pytest.fixture
def no_figures(monkeypatch):
    monkeypatch.setattr(api, "DRAWING", (draw_film,))


def film(folder, **how):
    return api.run(SMALLEST, folder, progress=False, **how).folder


def count(folder):
    return imageio_ffmpeg.count_frames_and_secs(folder / "void_ratio.mp4")[0]


def assert_film_can_follow(folder, filmed, why):
    """The run is whole, less its film, says so in one sentence, and the command in it draws the very film."""
    assert_same(folder, filmed, but=("void_ratio.mp4",))
    (words,) = json.loads((folder / "summary.json").read_text())["warnings"]
    assert words.startswith(f"The film is not drawn, because {why}")
    assert words.endswith(f"; `taichi-silo render {folder}` draws it later.") and words.count(". ") == 0
    assert words in (folder / "run.log").read_text()
    assert "finished = true" in (folder / "run.toml").read_text()
    assert Run(SMALLEST, folder, film=True).finished, "another attempt would fare no better"
    assert not (folder / "void_ratio.mp4").exists()


def test_a_run_steps_without_ffmpeg_and_without_matplotlib(tmp_path, filmed, monkeypatch, no_figures, tried):
    def none():
        raise RuntimeError("No ffmpeg exe could be found.")

    with monkeypatch.context() as patch:
        patch.setattr(imageio_ffmpeg._io, "get_ffmpeg_exe", none)
        assert_film_can_follow(film(tmp_path / "run"), filmed, "there is no ffmpeg")
        patch.setattr(imageio_ffmpeg._io, "get_ffmpeg_exe", lambda: str(tmp_path / "gone"))
        assert_film_can_follow(film(tmp_path / "second"), filmed, "ffmpeg cannot be started (No such")
    seconds = count(filmed) / 30
    assert seconds * 30 > FRAMES[1]
    words = ["-m", "taichi_silo.cli.app", "render", tmp_path / "run", "--seconds", f"{seconds}", "--quiet"]
    subprocess.run([sys.executable, *words], check=True, cwd=ROOT)
    assert_same(tmp_path / "run", filmed)
    tried("faults survived", "ffmpeg missing", 2)


BARE = """
import sys
sys.modules["matplotlib"] = sys.modules["imageio"] = sys.modules["imageio_ffmpeg"] = None
from taichi_silo import Scene, run
run(Scene.model_validate_json(sys.argv[1]), sys.argv[2], progress=False)
"""


def test_a_run_needs_no_library_that_draws(tmp_path, filmed, tried):
    folder = tmp_path / "run"
    subprocess.run([sys.executable, "-c", BARE, SMALLEST.model_dump_json(), str(folder)], check=True, cwd=ROOT)
    assert (folder / "forces.csv").read_bytes() == (filmed / "forces.csv").read_bytes()
    warnings = json.loads((folder / "summary.json").read_text())["warnings"]
    assert [words for words in warnings if "drawn" in words] == [
        f"The film is not drawn, because there is no matplotlib; `taichi-silo render {folder}` draws it later.",
        f"The figures are not drawn, because there is no matplotlib; `taichi-silo report {folder}` draws them later.",
    ]
    tried("faults survived", "no library that draws", 1)


def test_an_ffmpeg_that_dies_costs_the_film_and_is_not_waited_for(tmp_path, filmed, monkeypatch, no_figures, tried):
    start, killed = subprocess.Popen, []

    def started(command, *given, **how):
        process = start(command, *given, **how)
        if "rawvideo" in command:
            killed.append(process)
            process.kill()
        return process

    monkeypatch.setattr(subprocess, "Popen", started)
    assert_film_can_follow(film(tmp_path / "run"), filmed, "ffmpeg stopped before")
    assert len(killed) == 1
    tried("faults survived", "ffmpeg dying midway", 1)


def test_of_a_disk_that_is_full_ffmpeg_says_nothing_on_the_terminal(tmp_path, capfd):
    frames = np.random.default_rng(0).integers(0, 256, (20, 240, 320, 3), np.uint8)
    with Disk(tmp_path / "disk", 1 << 14) as disk, pytest.raises(FilmError, match="as when a disk is full"):
        encoder.encode(disk.place / "film.mp4", frames)
    assert capfd.readouterr() == ("", "")


def test_an_ffmpeg_that_dies_at_the_very_end_is_noticed(tmp_path, monkeypatch, tried):
    def cut_off(file):
        return len(FRAMES), 0.1

    monkeypatch.setattr(imageio_ffmpeg, "count_frames_and_secs", cut_off)
    with pytest.raises(FilmError, match="ffmpeg stopped before"):
        encoder.encode(tmp_path / "a.mp4", 5 * [np.zeros((90, 160, 3), np.uint8)])
    assert not list(tmp_path.iterdir())
    tried("faults survived", "ffmpeg dying midway", 1)


def test_a_disk_that_is_full_while_film_states_are_written_loses_none(tmp_path, filmed, monkeypatch, no_figures, tried):
    append, folder = AppendedFile.append, tmp_path / "run"

    def full(self, piece):
        late = self.file.name == film_states.NAME and self.size > 500
        with files_end_at(self.size + 30) if late else contextlib.nullcontext():
            append(self, piece)

    with monkeypatch.context() as patch:
        patch.setattr(AppendedFile, "append", full)
        with pytest.raises(MachineFailed, match=r"film_states.bin cannot be written: File too large"):
            film(folder)
    api.resume(folder, progress=False)
    assert_same(folder, filmed)
    tried("faults survived", "disk full while a file of a run is written", 1)


def test_a_run_that_goes_on_without_its_film_leaves_no_half_of_it(tmp_path, whole, monkeypatch, no_figures):
    folder = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        film(folder, extra=(At(40, send()),))
    (folder / "void_ratio.mp4").unlink()
    api.resume(folder, film=False, progress=False)
    assert_same(folder, whole)


# --- memory -----------------------------------------------------------------------------------------------------------


def test_a_scene_larger_than_the_memory_is_refused_before_any_work(tmp_path, monkeypatch, capsys, tried):
    local = Averaging(characteristic_length_m=0.0)
    scene = smallest(grid=Mesh(cell_size_m=0.001), averaging=local)
    assert memory_need.needed(SMALLEST) < memory_need.needed(scene) < 2 * memory_need.GIB < memory_need.available()
    group = tmp_path / "memory.max"
    monkeypatch.setattr(memory_need, "GROUPS", (tmp_path / "none", group))
    group.write_text("max\n")
    unlimited = memory_need.available()
    group.write_text("300000000\n")
    assert memory_need.available() == 3e8 < unlimited
    with pytest.raises(BadInput, match=r"80,000 points need about 0\.\d+ GiB of memory, and .* at most 0.279 GiB"):
        run(scene, tmp_path / "run")
    words = ("run", "outlet", "--output", tmp_path / "run", "--cell-size", "0.0005", "--quiet")
    code, err = failed(monkeypatch, capsys, *words)
    assert code == 2 and "points need about" in err
    assert not (tmp_path / "run").exists()
    tried("faults survived", "memory that does not suffice", 2)


def refused_by_the_card():
    raise RuntimeError("CUDA Error CUDA_ERROR_OUT_OF_MEMORY: out of memory while calling malloc_async")


@pytest.mark.parametrize("take", [lambda: bytearray(1 << 50), refused_by_the_card], ids=["memory", "a card's memory"])
def test_memory_that_runs_out_midway_ends_with_a_sentence_and_the_run_goes_on(take, tmp_path, whole, tried):
    folder = tmp_path / "run"
    with pytest.raises(MachineFailed, match=r"^stopped at t = 0.* because memory has run out; leave it more memory"):
        run(SMALLEST, folder, extra=(At(70, take),))
    assert_sound(folder, whole)
    resume(folder)
    assert_same(folder, whole)
    tried("faults survived", "memory running out midway")
