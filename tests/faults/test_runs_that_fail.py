"""A run that goes wrong stops with time, place and cause, and keeps everything up to then."""

import json

import numpy as np
import pandas as pd
import pytest

from taichi_silo import Flow, Machine, Mesh, Method, RunFailed, Scene, Silo, Walls, run
from taichi_silo.runs.observers import Observer
from taichi_silo.utils import checked_npz
from tests.faults.harness import assert_finite

SCENE = Scene(
    grid=Mesh(cell_size_m=0.05), flow=Flow(speed_m_per_s=0.02, displacement_m=0.004), method=Method(filling_time_s=0.2)
)


class Saboteur(Observer):
    """Changes a field of the points at a time."""

    def __init__(self, time_s, stage="filling", **fields):
        self.time, self.stage, self.fields, self.done = time_s, stage, fields, False

    def begin(self, simulation):
        self.simulation = simulation

    def observe(self, record):
        if record.time_s > self.time and record.stage == self.stage and not self.done:
            arrays = self.simulation.model.particles.arrays()
            for name, value in self.fields.items():
                arrays[name][7] = value
            self.simulation.model.particles.load(arrays)
            self.done = True


def fails(folder, scene=SCENE, extra=()):
    with pytest.raises(RunFailed) as caught:
        run(scene, folder, film=False, extra=extra)
    forces = pd.read_csv(folder / "forces.csv")
    summary = json.loads((folder / "summary.json").read_text())
    assert not summary["finished"]
    assert summary["failure"] == str(caught.value)
    assert len(forces) > 3
    assert np.isfinite(forces.drop(columns="stage")).all(axis=None)
    assert_finite(folder)
    return str(caught.value)


def test_a_failure_at_the_very_start_of_the_flow_keeps_the_filling(tmp_path):
    message = fails(tmp_path / "run", extra=(Saboteur(0.0, stage="flow", stress=np.nan),))
    assert "(flow, u = 0.0" in message
    assert {file.name for file in (tmp_path / "run" / "figures").iterdir()} >= {"forces.png", "void_ratio.png"}
    points = checked_npz.read(tmp_path / "run" / "checkpoint.npz")[1]["simulation"]["points"]
    assert all(np.isfinite(values).all() for values in points.values())


def smooth_silo(stress_filter):
    return Scene(
        walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=0.05), flow=Flow(speed_m_per_s=0.02, displacement_m=0.002),
        method=Method(filling_time_s=0.2, stress_filter=stress_filter),
    )  # fmt: skip


def test_the_smoothing_filter_lets_sand_creep_until_the_guard_says_so(tmp_path):
    message = fails(tmp_path / "run", smooth_silo("smoothing"))
    assert "denser than any packing; the smoothing filter lets sand creep" in message
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert any("no projection" in sentence for sentence in summary["warnings"])


def test_the_null_space_filter_does_not(tmp_path, bare):
    run(smooth_silo("null-space"), tmp_path / "run", film=False)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["finished"]
    assert "warnings" not in summary
    assert abs(summary["certificate"]["mean_void_ratio_drift"]) < 0.003


@pytest.mark.long
def test_a_slender_silo_whose_sand_ratchets_is_noticed_while_it_runs(tmp_path, bare):
    """Its forces look fine; void ratio without shear tells."""
    scene = Scene(
        silo=Silo(width_m=0.02, height_m=0.5),
        walls=Walls(kind="smooth", friction_angle_deg=19.0), grid=Mesh(cell_size_m=0.005),
        flow=Flow(speed_m_per_s=0.005, displacement_m=0.002), machine=Machine(threads=1),
    )  # fmt: skip
    run(scene, tmp_path / "run", film=False)
    swinging, ratcheting = json.loads((tmp_path / "run" / "summary.json").read_text())["warnings"]
    assert "times the kinetic energy" in swinging and "it falls or oscillates instead of following" in swinging
    assert "ratcheting" in ratcheting and "slender" in ratcheting


def test_overwriting_leaves_nothing_of_the_earlier_run(tmp_path, bare):
    folder = tmp_path / "run"
    (folder / "snapshots").mkdir(parents=True)
    for name in ("run.toml", "void_ratio.mp4", "summary.json", "snapshots/old.vtu"):
        (folder / name).write_text("old")
    with pytest.raises(RunFailed):
        run(SCENE, folder, overwrite=True, film=False, extra=(Saboteur(0.05, stress=np.nan),))
    assert not (folder / "void_ratio.mp4").exists()
    assert not (folder / "snapshots" / "old.vtu").exists()
    assert "old" not in (folder / "run.toml").read_text()


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param(
            {"silo": {"width_m": 0.1, "height_m": 0.1}, "flow": {"speed_m_per_s": 0.02, "displacement_m": 0.002}},
            marks=pytest.mark.long,
        ),
        {"flow": {"speed_m_per_s": 0.3, "displacement_m": 0.002}},
        {"flow": {"speed_m_per_s": 0.02, "displacement_m": 1e-7}},
        pytest.param({"flow": {"speed_m_per_s": 0.1, "displacement_m": 0.08}}, marks=pytest.mark.long),
        pytest.param({"grid": {"cell_size_m": 0.05, "points_per_cell": 4}}, marks=pytest.mark.long),
        pytest.param(
            {"method": {"noise_control": "none", "filling_time_s": 0.2, "longest_settling_s": 0.1}},
            marks=pytest.mark.long,
        ),
    ],
    ids=["two by two cells", "ends in the ramp", "one interval", "sand hangs far above", "four points", "no control"],
)
def test_extreme_scenes_end_well(tmp_path, bare, changes):
    run(Scene.model_validate(SCENE.model_dump() | changes), tmp_path / "run", film=False)
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["finished"]
