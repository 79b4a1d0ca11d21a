"""A run that was left and gone on with is, bit by bit, the run that was never left.

While a run goes on, a checkpoint is written at chosen moments, and some records later its folder is copied, as a kill
at that moment would leave it. The copies are gone on with, and must become the folder of the run.
"""

import json
import shutil
import subprocess
from functools import partial

import imageio_ffmpeg
import numpy as np
import pytest

from taichi_silo import api
from taichi_silo.errors import Stopped
from taichi_silo.runs import session
from taichi_silo.runs.observers import film_recorder
from taichi_silo.runs.observers.checkpoint import Checkpoint
from taichi_silo.runs.session import resume, run
from taichi_silo.scene.scene import Averaging, Filling, Flow, Machine, Mesh, Method, Output, Scene, Silo, Walls
from taichi_silo.scene.silo import Hopper, Outlet
from taichi_silo.show.run_end import draw_film
from tests.faults.harness import At, assert_same, send

pytestmark = pytest.mark.usefixtures("bare")
SMOOTH, ROUGH = Walls(kind="smooth", friction_angle_deg=19.0), Walls(kind="very-rough")
LOW = Silo(height_m=0.4)
FLOW, FAST = Flow(speed_m_per_s=0.05, displacement_m=0.002), Flow(speed_m_per_s=0.5, displacement_m=0.16)
FREE = Flow(outflow="gravity", displacement_m=2.0, longest_s=0.2)
BESIDE = Silo(height_m=0.24, outlet=Outlet(width_m=0.12, position="right"))
HOPPER = Silo(height_m=0.4, hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.1))
LATER = 3  # records from the checkpoint to the copy
AFFINE = {"transfer": "apic", "stress_filter": "smoothing"}


def scene(silo=LOW, walls=SMOOTH, flow=FLOW, cell=0.05, method=None, shape="ugimp", **tables):
    return Scene(
        silo=silo, walls=walls, flow=flow, grid=Mesh(cell_size_m=cell, shape=shape),
        method=Method(filling_time_s=0.1, longest_settling_s=0.0, **(method or {})),
        output=Output(records_per_period=4),
        machine=Machine(threads=1, lanes=False), **tables,
    )  # fmt: skip


def half_filled(simulation):
    return simulation.filling.intervals == 12


def coming_to_rest(simulation):
    return simulation.filling.rest == 8


def half_sunk(simulation):
    return simulation.displacement > 0.5 * simulation.scene.flow.displacement_m


def sand_has_left(simulation):
    return simulation.discharge.points > 0


def at_the_end(simulation):
    return simulation.clock.finished or simulation.displacement >= simulation.scene.flow.displacement_m * (1.0 - 1e-12)


SCENES = {  # and the moments
    "very rough walls": (scene(walls=ROUGH), (half_sunk,)),
    "half of smooth walls": (scene(), (coming_to_rest, at_the_end)),
    "outlet beside a wall, non-local": (
        scene(BESIDE, flow=FAST, cell=0.04, averaging=Averaging(characteristic_length_m=0.08)), (sand_has_left,),
    ),
    "hopper": (scene(HOPPER, flow=FAST.model_copy(update={"displacement_m": 0.05})), (half_sunk,)),
    "free outflow": (scene(Silo(height_m=0.2, outlet=Outlet(width_m=0.16)), ROUGH, FREE, 0.02), (sand_has_left,)),
    "free hopper": (scene(HOPPER, flow=FREE.model_copy(update={"longest_s": 0.5}), cell=0.02), (sand_has_left,)),
    "round": (scene(Silo(height_m=0.4, section="round")), (half_filled,)),
    "layers": (  # each takes four records
        scene(Silo(height_m=0.4, half="no"), ROUGH, filling=Filling(kind="layers", layers=4)), (half_filled,),
    ),
    "rain, affine": (
        scene(Silo(height_m=0.1, half="no"), ROUGH, shape="cpdi", method=AFFINE,
              filling=Filling(kind="rain", drop_m=0.02)),
        (half_filled,),
    ),
}  # fmt: skip
OFTEN = {  # name, threads, lanes; the others with `make test-long`
    ("very rough walls", 2, True), ("half of smooth walls", 1, True),
    ("rain, affine", 1, False), ("free hopper", 1, True),
}  # fmt: skip
CASES = [
    pytest.param(
        name, threads, lanes, id=f"{name}, {threads} threads, {'lanes' if lanes else 'plain'}",
        marks=[] if (name, threads, lanes) in OFTEN else pytest.mark.long,
    )
    for name in SCENES for threads in (1, 2) for lanes in (False, True) if not (lanes and "affine" in name)
]  # fmt: skip


def photographed(one, folder, moments, monkeypatch, run=run):
    """Run a scene; the copies of its folder after each of the moments."""
    copies = {moment: folder.with_name(f"{folder.name}_{moment.__name__}") for moment in moments}

    class Photographer(Checkpoint):
        def begin(self, simulation):
            super().begin(simulation)
            self.since = {}

        def observe(self, record):
            for moment, copy in copies.items():
                if moment in self.since:
                    self.since[moment] += 1
                elif moment(self.simulation):
                    self.since[moment] = 0
                    self.write()
                if self.since.get(moment) == LATER or moment is at_the_end and self.since.get(moment) == 0:
                    shutil.copytree(self.folder, copy)

    with monkeypatch.context() as patch:
        patch.setattr(session, "Checkpoint", Photographer)
        run(one, folder)
    return copies.values()


@pytest.mark.parametrize(("name", "threads", "lanes"), CASES)
def test_a_run_that_was_killed_becomes_the_run_that_was_not(
    name, threads, lanes, tmp_path, monkeypatch, request, tried
):
    if threads > 1:
        request.getfixturevalue("all_cores")
    one, moments = SCENES[name]
    one = one.model_copy(update={"machine": Machine(threads=threads, lanes=lanes)})
    for copy in photographed(one, tmp_path / "whole", moments, monkeypatch):
        assert (copy / "forces.csv").stat().st_size <= (tmp_path / "whole" / "forces.csv").stat().st_size
        resume(copy)
        assert_same(copy, tmp_path / "whole")
        tried("faults survived", f"run killed, goes on bit by bit the same on {threads} thread{'s' * (threads > 1)}")


def frames(file):
    """Times, in frames, and small grey pictures of a film."""
    program = imageio_ffmpeg.get_ffmpeg_exe()
    listed = subprocess.run([program, "-i", file, "-f", "framemd5", "-"], capture_output=True, text=True).stdout
    times = [int(line.split(",")[2]) for line in listed.splitlines() if not line.startswith("#")]
    scale = "-vf scale=240:135 -f rawvideo -pix_fmt gray -".split()  # noqa: SIM905
    raw = subprocess.run([program, "-i", file, *scale], capture_output=True).stdout
    return times, np.frombuffer(raw, np.uint8).reshape(-1, 135, 240).astype(int)


def test_the_film_of_a_run_that_was_stopped_and_killed_has_every_frame_once(tmp_path, monkeypatch, tried):
    monkeypatch.setitem(film_recorder.FRAMES, "filling", 10)
    monkeypatch.setitem(film_recorder.FRAMES, "flow", 10)
    monkeypatch.setattr(api, "DRAWING", (draw_film,))
    one, run, resume = scene(), partial(api.run, progress=False), partial(api.resume, progress=False)
    (killed,) = photographed(one, tmp_path / "whole", (half_sunk,), monkeypatch, run)
    assert not (killed / "void_ratio.mp4").exists(), "no film is drawn while a run steps"
    resume(killed)
    stopped = tmp_path / "stopped"
    with pytest.raises(Stopped, match=r"stopped at t = 0\.\d+ s \(filling, u = 0\.000 mm\); `taichi-silo resume"):
        run(one, stopped, extra=(At(40, send()),))
    assert not (stopped / "void_ratio.mp4").exists(), "a run that is stopped ends at once"
    resume(stopped)
    times, pictures = frames(tmp_path / "whole" / "void_ratio.mp4")
    assert times == list(range(len(times))) and len(times) > 15
    assert np.abs(np.diff(pictures, axis=0)).mean(axis=(1, 2)).min() > 0.0, "each picture is another one"
    for folder in (killed, stopped):
        assert_same(folder, tmp_path / "whole")  # byte by byte, film and all
    tried("faults survived", "film of a run killed or stopped, every frame once", 2)


@pytest.mark.parametrize("left", ["{ no", None], ids=["damaged", "lost"])
def test_a_run_whose_summary_is_gone_writes_it_once_more(left, tmp_path, tried):
    folder = run(scene(), tmp_path / "whole")
    file, tables = folder / "summary.json", [folder / name for name in ("forces.csv", "walls.csv")]
    found, before = json.loads(file.read_text()), [table.read_bytes() for table in tables]
    file.unlink() if left is None else file.write_text(left)
    resume(folder)
    again = json.loads(file.read_text())
    assert again.pop("cost")["steps"] == found.pop("cost")["steps"] and again == found
    assert [table.read_bytes() for table in tables] == before
    tried("faults survived", "summary of a run that has ended, damaged or lost, written once more")
