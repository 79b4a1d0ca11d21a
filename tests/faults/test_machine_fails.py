"""Folders that vanish, clocks that jump, an ffmpeg that dies, too little memory: a run says so, or goes on."""

import contextlib
import json
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import imageio_ffmpeg
import pytest

from taichi_silo.errors import BadInput, MachineFailed
from taichi_silo.runs.session import resume, run
from taichi_silo.scene import memory_need
from taichi_silo.scene.scene import Averaging, Mesh
from taichi_silo.show.film import encoder, movie
from taichi_silo.studies.sweep.runs import Run
from tests.faults.harness import At, Disk, assert_readable, assert_same, assert_sound, contents, failed, nobody, send
from tests.smallest import SMALLEST, smallest

OFTEN = smallest(output={"checkpoint_s": 0.02})
FRAMES = (4, 8)


@pytest.fixture(autouse=True, scope="module")
def short_films(quick):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(movie, "FILLING_FRAMES", FRAMES[0])
        patch.setattr(movie, "FLOW_FRAMES", FRAMES[1])
        yield


def test_a_folder_that_is_removed_ends_the_run_soon_and_is_not_made_again(tmp_path, tried):
    folder = tmp_path / "run"
    with pytest.raises(MachineFailed, match=f"because the folder {folder} was gone, and .*; if it was removed, begin"):
        run(OFTEN, folder, film=False, extra=(At(20, lambda: shutil.rmtree(folder)),))
    assert not folder.exists()
    tried("faults survived", "output folder removed midway")


def test_a_folder_that_is_moved_goes_on_under_its_new_name(tmp_path, whole, tried):
    folder, moved = tmp_path / "run", tmp_path / "moved"
    with pytest.raises(MachineFailed, match=f"the folder {folder} was gone"):
        run(OFTEN, folder, film=False, extra=(At(30, lambda: folder.rename(moved)),))
    assert_sound(moved, whole)
    resume(moved)
    assert_same(moved, whole)
    tried("faults survived", "output folder moved midway")


def test_curves_that_are_removed_while_they_are_written_are_missed(tmp_path, tried):
    folder = tmp_path / "run"
    with pytest.raises(MachineFailed, match=r"forces.csv cannot be written: it has been removed; put it back"):
        run(OFTEN, folder, film=False, extra=(At(20, (folder / "forces.csv").unlink),))
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
            run(SMALLEST, folder, film=False, extra=(At(20, close),))
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
        folder = run(SMALLEST, disk.place / "run", film=False)
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

    run(SMALLEST, tmp_path / "run", film=False, extra=tuple(At(number, jump) for number in (5, 30, 50)))
    assert not jumps
    assert_same(tmp_path / "run", whole)
    tried("faults survived", "clock set forward or back by hours", 3)


# --- the film ---------------------------------------------------------------------------------------------------------


def film_warning(folder):
    return [words for words in json.loads((folder / "summary.json").read_text())["warnings"] if "film" in words]


def assert_without_film(folder, whole):
    """The run is whole, less its film, and says so; nothing half-written is left."""
    assert_same(folder, whole, but=("void_ratio.mp4",))
    (words,) = film_warning(folder)
    assert words.endswith(f"; `taichi-silo render {folder} --overwrite` draws it from the snapshots.")
    assert 'film = "ended early"' in (folder / "run.toml").read_text()
    assert Run(SMALLEST, folder, film=True).finished, "another attempt would fare no better"
    return words


def test_without_ffmpeg_there_is_no_film_but_the_run(tmp_path, whole, monkeypatch, tried):
    def none():
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", none)
    run(SMALLEST, tmp_path / "run")
    assert assert_without_film(tmp_path / "run", whole).startswith("There is no film, because there is no ffmpeg; ")
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", lambda: str(tmp_path / "gone"))
    run(SMALLEST, tmp_path / "second")
    assert "no film, because ffmpeg cannot be started (No such" in assert_without_film(tmp_path / "second", whole)
    tried("faults survived", "ffmpeg missing", 2)


class Killer(At):
    """Kills ffmpeg while it draws, from so many records on."""

    def __init__(self, records):
        super().__init__(records, None)
        self.processes, self.count = [], 0

    def begin(self, simulation):
        super().begin(simulation)
        start = subprocess.Popen

        def started(*given, **how):
            self.processes.append(start(*given, **how))
            return self.processes[-1]

        self.patch = pytest.MonkeyPatch()
        self.patch.setattr(encoder.subprocess, "Popen", started)

    def observe(self, record):
        self.left -= 1
        if self.left < 0 and not self.count and self.processes and self.processes[-1].poll() is None:
            self.count += 1
            self.processes[-1].kill()

    def end(self):
        self.patch.undo()


def test_an_ffmpeg_that_dies_costs_the_rest_of_the_film(tmp_path, whole, tried):
    killer, folder = Killer(30), tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        run(SMALLEST, folder, extra=(At(40, send()),))
    with pytest.raises(KeyboardInterrupt):
        resume(folder, extra=(killer, At(60, send())))
    resume(folder)
    assert killer.count == 1
    words = assert_without_film(folder, whole)
    assert words.startswith("The film ends at t = 0.") and "it was ended by signal 9" in words
    listed = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), "-i", folder / "void_ratio.mp4", "-f", "framemd5", "-"], capture_output=True,
        text=True,
    )  # fmt: skip
    assert 0 < listed.stdout.count("\n0,") < sum(FRAMES), "what was drawn by then can be seen"
    tried("faults survived", "ffmpeg dying midway", 1)


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
        run(scene, tmp_path / "run", film=False)
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
        run(SMALLEST, folder, film=False, extra=(At(70, take),))
    assert_sound(folder, whole)
    resume(folder)
    assert_same(folder, whole)
    tried("faults survived", "memory running out midway")
