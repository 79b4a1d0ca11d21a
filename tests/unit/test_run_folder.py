"""What a run leaves behind: the contract that users' scripts rely on."""

import json
import os
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import meshio
import numpy as np
import pandas as pd
import pytest

from taichi_silo.mpm import language
from taichi_silo.runs.run_folder import go_on
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.utils import checked_npz

SCRIPT = Path(__file__).parents[2] / "scenarios" / "mass_flow.py"
FORCES = (
    "time_s stage displacement_m bottom_force_N_per_m left_normal_N_per_m left_shear_N_per_m right_normal_N_per_m "
    "right_shear_N_per_m wall_friction_angle_deg weight_N_per_m discharged_kg_per_m kinetic_energy_J_per_m"
)


def coarse(place, *flags):
    """Run the scenario of mass flow with cells of 50 mm, as a user does."""
    words = ["--cell-size", "0.05", "--speed", "0.05", "--displacement", "0.01", "--walls", "smooth", "--threads", "1"]
    command = [sys.executable, str(SCRIPT), *words, "--output", str(place), *flags]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "%" in done.stdout + done.stderr
    assert str(place) in done.stdout.replace("\n", "")
    return place


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return coarse(tmp_path_factory.mktemp("runs") / "coarse", "--no-film")


def test_forces_have_the_promised_columns_and_stages(folder):
    forces = pd.read_csv(folder / "forces.csv")
    assert list(forces.columns) == FORCES.split()
    assert set(forces.stage) == {"filling", "flow"}
    assert (forces[forces.stage == "filling"].displacement_m == 0).all()
    assert forces.displacement_m.iloc[-1] == pytest.approx(0.01)
    assert forces.time_s.is_monotonic_increasing


def test_forces_and_balance_close_row_by_row_from_the_files_alone(folder):
    forces, balance = pd.read_csv(folder / "forces.csv"), pd.read_csv(folder / "balance.csv")
    carried = forces.bottom_force_N_per_m + forces.left_shear_N_per_m + forces.right_shear_N_per_m
    rest = forces.weight_N_per_m + balance.momentum_rate_N_per_m - balance.noise_control_force_N_per_m
    assert (carried - rest).abs().max() < 1e-9 * forces.weight_N_per_m.max()


def test_wall_stresses_add_up_to_the_wall_force(folder):
    walls, forces = pd.read_csv(folder / "walls.csv"), pd.read_csv(folder / "forces.csv")
    assert list(walls.columns) == ["state", "wall", "height_m", "normal_stress_Pa", "shear_stress_Pa"]
    assert set(walls.state) == {"filling", "maximum", "residual"}
    assert set(walls.wall) == {"left", "right", "bottom"}
    last = forces[forces.stage == "filling"].tail(10)
    for wall, column in (("left", "left_normal_N_per_m"), ("right", "right_normal_N_per_m")):
        rows = walls[(walls.state == "filling") & (walls.wall == wall)]
        share = np.full(len(rows), 0.05)
        share[0] = 0.025
        assert (rows.normal_stress_Pa * share).sum() == pytest.approx(last[column].mean(), rel=1e-3)


def test_parameters_run_again(folder):
    scene = read_scene(folder / "run.toml")
    assert scene.grid.cell_size_m == 0.05
    assert scene.walls.kind == "smooth"
    assert scene.walls.friction_angle_deg == 19.0
    place = folder.parent / "again"
    words = ["run", str(folder / "run.toml"), "--output", str(place), "--no-film"]
    command = [sys.executable, "-m", "taichi_silo.cli.app", *words]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    assert (place / "forces.csv").read_text() == (folder / "forces.csv").read_text()
    text = (folder / "run.toml").read_text()
    assert all(name in text for name in ("revision", language.NAME, "precision", "wall_seconds", "arch"))


def test_snapshots_open_and_hold_the_fields(folder):
    index = pd.read_csv(folder / "snapshots" / "index.csv")
    named = index[~index.file.str.startswith("film_")]
    assert pytest.approx(named.displacement_m[1:].tolist(), abs=2e-4) == [0.0, 0.001, 0.0025, 0.005, 0.01]
    assert 60 < len(index) - len(named) <= 110
    mesh = meshio.read(folder / "snapshots" / index.file.iloc[-1])
    assert len(mesh.points) == 40
    assert {"void_ratio", "velocity", "stress_Pa", "volume_m2_per_m"} <= set(mesh.point_data)


@pytest.mark.long
def test_the_film_plays_in_a_browser(tmp_path):
    folder = coarse(tmp_path / "filmed")
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(folder / "void_ratio.mp4"))
    assert 14.0 < seconds < 16.0
    assert 420 < frames < 460
    reader = imageio_ffmpeg.read_frames(str(folder / "void_ratio.mp4"))
    about = next(reader)
    reader.close()
    assert about["size"] == (1920, 1080)
    assert about["codec"] == "h264"
    assert about["pix_fmt"].startswith("yuv420p")


def test_figures_and_checkpoint_are_there(folder):
    names = {file.name for file in (folder / "figures").iterdir()}
    assert names == {"forces.png", "wall_friction_angle.png", "void_ratio.png", "wall_stress.png"}
    _, kept = checked_npz.read(folder / "checkpoint.npz")
    simulation = kept["simulation"]
    assert {"position", "velocity", "stress", "mass", "volume", "path", "identity"} <= simulation["points"].keys()
    assert simulation["clock"]["finished"] and "memory" in simulation["nodes"]
    assert not [file for file in folder.rglob("*part*")]


def test_the_summary_holds_peaks_certificate_and_cost(folder):
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["finished"]
    assert {"filling", "peak", "residual", "certificate", "janssen", "shear_zones", "cost"} <= set(summary)
    assert summary["cost"]["points"] == 20  # of the half that is computed
    assert [part["choice"] for part in summary["parts"] if part["part"] == "half model"] == ["on"]
    assert set(summary["cost"]) >= {"points", "steps", "time_step_s", "seconds", "particle_steps_per_second"}
    certificate = summary["certificate"]
    assert certificate["force_balance_residual_over_weight"] < 1e-9
    assert {
        "kinetic_energy_over_rigid_motion", "largest_kinetic_energy_over_work", "inertial_number_99th_percentile",
        "noise_of_normal_force", "mean_void_ratio_drift", "core_strain_path", "unexplained_densification",
    } <= set(certificate)  # fmt: skip


@pytest.mark.skipif(os.name == "nt", reason="another shell")
@pytest.mark.parametrize("name", ["plain", "a b", "-dash", "~home", "$HOME", "it's", 'a"b', "a;b", "#1", "a*"])
def test_a_command_that_is_told_can_be_typed_as_it_stands(name):
    command = go_on(Path(name)).removeprefix("taichi-silo resume ")
    echoed = subprocess.run(
        ["/bin/sh", "-c", f"printf %s {command}"], capture_output=True, text=True, timeout=60
    ).stdout
    assert Path(echoed) == Path(name)
    assert not command.startswith("-")
