"""Figures are drawn from the files of a run, complete or not."""

import json

import meshio
import numpy as np
import pandas as pd
import pytest
import tomli_w
from PIL import Image

from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.show.figures import plot_cases, plot_run
from taichi_silo.show.figures.run_files import RunFiles, critical_simple_shear_angle_deg
from taichi_silo.show.figures.void_ratio import chosen_snapshots

WIDTH, HEIGHT = 0.2, 0.5
NAMES = ["forces.png", "wall_friction_angle.png", "void_ratio.png", "wall_stress.png"]


def write_run(folder, void_ratio=0.60, kind="smooth", last_mm=20.0, columns=16, rows=40, force_rows=600):
    """Write what a run leaves behind; with last_mm = None it ended while the silo was being filled."""
    rough, loose = kind == "very-rough", void_ratio > 0.75
    angle = 12.3 if loose else 19.0
    fill = Janssen(WIDTH, HEIGHT, 2650 * 9.81 / (1 + void_ratio), 29.4 if rough else angle, 0.42)
    parameters = {
        "silo": {"width_m": WIDTH, "height_m": HEIGHT},
        "sand": {
            "void_ratio": void_ratio,
            "grain_density_kg_per_m3": 2650.0,
            "critical_friction_angle_deg": 30.0,
        },
        "walls": {"kind": kind, "friction_angle_deg": angle},
        "grid": {"cell_size_m": WIDTH / columns, "points_per_cell": 1},
        "flow": {"speed_m_per_s": 0.002, "displacement_m": 0.02},
    }
    (folder / "snapshots").mkdir(parents=True)
    (folder / "run.toml").write_text(tomli_w.dumps(parameters))
    random = np.random.default_rng(5)

    u = np.zeros(0) if last_mm is None else np.linspace(0.0, last_mm, force_rows)
    filling_time = np.linspace(0.0, 1.0, force_rows // 4)
    weight = fill.weight_N_per_m
    shear = fill.shear_force_N_per_m * np.ones_like(u)
    normal = fill.normal_force_N_per_m * np.ones_like(u)
    if rough:
        softening = (0.24, 0.02, 0.03) if loose else (0.394, 0.055, 0.123)
        residual, peak, rise = softening
        shear = weight * (residual + peak * np.exp(-u / 4) - rise * np.exp(-u / 0.15))
        normal = weight * (0.40 if loose else 0.60 - 0.26 * np.exp(-u / 4)) + 0 * u
    start_shear, start_normal = (shear[0], normal[0]) if len(u) else (0.2 * weight, 0.4 * weight)
    ramp = np.minimum(filling_time / 0.6, 1.0)
    shear = np.concatenate([ramp * start_shear, shear])
    normal = np.concatenate([ramp * start_normal, normal])
    noise = 0.02 * weight * random.standard_normal((3, len(shear)))
    table = pd.DataFrame(
        {
            "time_s": np.concatenate([filling_time, 1.0 + u / 2.0]),
            "stage": ["filling"] * len(filling_time) + ["flow"] * len(u),
            "displacement_m": np.concatenate([0 * filling_time, u / 1e3]),
            "bottom_force_N_per_m": np.concatenate([ramp * weight, weight + 0 * u]) - 2 * shear + noise[0],
            "left_normal_N_per_m": normal + noise[1],
            "left_shear_N_per_m": shear + 0.5 * noise[1],
            "right_normal_N_per_m": normal + noise[2],
            "right_shear_N_per_m": shear + 0.5 * noise[2],
        }
    )
    ratio = (table["left_shear_N_per_m"] + table["right_shear_N_per_m"]) / (2 * np.maximum(normal, 1.0))
    table["wall_friction_angle_deg"] = np.degrees(np.arctan(ratio))
    table["weight_N_per_m"] = weight
    table["discharged_kg_per_m"] = table["kinetic_energy_J_per_m"] = 0.0
    table.to_csv(folder / "forces.csv", index=False)
    write_snapshots(folder, void_ratio, rough, loose, last_mm, columns, rows)
    if last_mm is not None:
        write_walls(folder, fill, rough and not loose, random)
        (folder / "summary.json").write_text(
            json.dumps({"janssen": {"pressure_ratio_K0": 0.42, "pressure_ratio_measured": 0.45}})
        )
    return folder


def write_snapshots(folder, void_ratio, rough, loose, last_mm, columns, rows):
    x, y = np.meshgrid((np.arange(columns) + 0.5) * WIDTH / columns, (np.arange(rows) + 0.5) * HEIGHT / rows)
    x, y = x.ravel(), y.ravel()
    index = []
    for u in [0.0] if last_mm is None else np.arange(0.0, last_mm + 0.1, 1.0):
        wall = np.minimum(x, WIDTH - x)
        zones = np.exp(-((wall / (0.012 if rough else 0.002)) ** 2))
        if rough and not loose:
            arch = y + 7.0 * (x - 0.5 * WIDTH) ** 2
            zones = zones + 0.8 * sum(np.exp(-(((arch - apex) / 0.008) ** 2)) for apex in (0.12, 0.24, 0.38))
        growth = (-0.06 if loose else 0.2) * (1 - np.exp(-u / 4))
        field = void_ratio + growth * np.minimum(zones, 1.0) - 0.01 * (HEIGHT - y)
        points = np.column_stack([x, y - u / 1e3 * np.minimum(1.0, 0.4 + wall / 0.02), 0 * x])
        data = {
            "void_ratio": field,
            "volume_m2_per_m": WIDTH * HEIGHT / len(x) * (1 + field) / (1 + void_ratio),
            "velocity": np.zeros((len(x), 3)),
        }
        file = f"{int(1000 * u):06d}.vtu"
        cells = [("vertex", np.arange(len(x))[:, None])]
        meshio.Mesh(points, cells, point_data=data).write(folder / "snapshots" / file)
        index.append((file, "filling" if u == 0 else "flow", 1.0 + u / 2.0, u / 1e3))
    names = ["file", "stage", "time_s", "displacement_m"]
    pd.DataFrame(index, columns=names).to_csv(folder / "snapshots" / "index.csv", index=False)


def write_walls(folder, fill, wavy, random):
    rows = []
    height = (np.arange(100) + 0.5) * HEIGHT / 100
    for state, factor in (("filling", 1.0), ("maximum", 1.3), ("residual", 1.2)):
        waves = wavy and state != "filling"
        wave = 0.35 * waves * np.sin(2 * np.pi * (height + 0.1 * factor) / 0.12)
        for wall in ("left", "right"):
            local = 1.0 + 0.04 * random.standard_normal(100)
            normal = fill.normal_stress_Pa(HEIGHT - height) * factor * (1 + wave) * local
            shear = fill.wall_friction * normal
            rows += [(state, wall, *row) for row in zip(height, normal, shear, strict=True)]
        rows += [(state, "bottom", x, 4e3, 0.0) for x in np.linspace(0, WIDTH, 9)]
    names = ["state", "wall", "height_m", "normal_stress_Pa", "shear_stress_Pa"]
    pd.DataFrame(rows, columns=names).to_csv(folder / "walls.csv", index=False)


def assert_drawn(paths, names):
    assert [path.name for path in paths] == names
    for path in paths:
        image = np.asarray(Image.open(path).convert("RGB"))
        assert min(image.shape[:2]) > 400
        assert np.mean(np.any(image < 200, axis=2)) > 0.01  # something is there beside the paper


@pytest.mark.parametrize("kind", ["smooth", "very-rough"])
def test_figures_of_a_run(tmp_path, kind):
    folder = write_run(tmp_path / "run", kind=kind)
    paths = plot_run(folder)
    assert_drawn(paths, NAMES)
    assert {path.parent for path in paths} == {folder / "figures"}


def test_a_run_that_ended_while_filling_is_drawn(tmp_path):
    assert_drawn(plot_run(write_run(tmp_path / "run", last_mm=None)), NAMES[:3])


def test_an_empty_folder_draws_nothing(tmp_path):
    assert plot_run(tmp_path) == []
    assert plot_cases({"nothing": tmp_path}, tmp_path / "figures") == []


def test_files_without_rows_or_parameters_are_no_error(tmp_path):
    folder = write_run(tmp_path / "run", last_mm=3.0)
    (folder / "run.toml").write_text("")
    (folder / "summary.json").unlink()
    (folder / "walls.csv").write_text("")
    next((folder / "snapshots").glob("*.vtu")).unlink()
    assert_drawn(plot_run(folder), NAMES[:3])


def test_a_run_that_went_wrong_is_drawn(tmp_path):
    folder = write_run(tmp_path / "run", last_mm=6.0)
    forces = pd.read_csv(folder / "forces.csv")
    forces.iloc[-3:, 3:9] = [[np.nan] * 6, [np.inf] * 6, [1e200] * 6]
    forces.to_csv(folder / "forces.csv", index=False)
    last = folder / "snapshots" / "006000.vtu"
    mesh = meshio.read(last)
    mesh.points[3], mesh.point_data["void_ratio"][5] = np.nan, np.inf
    mesh.point_data["volume_m2_per_m"][7] = -1.0
    mesh.write(last)
    assert_drawn(plot_run(folder), NAMES)


def test_figures_of_several_runs(tmp_path):
    folders = {
        "dense, smooth": write_run(tmp_path / "a"),
        "dense, very rough": write_run(tmp_path / "b", kind="very-rough", last_mm=6.0),
        "loose, smooth": write_run(tmp_path / "c", 0.90, last_mm=None),
    }
    assert_drawn(plot_cases(folders, tmp_path / "figures"), NAMES)


@pytest.mark.parametrize(
    "last_mm, expected", [(None, [0]), (20.0, [0, 2, 5, 10, 20]), (8.0, [0, 2, 5, 8]), (2.0, [0, 2])]
)
def test_snapshots_nearest_to_the_wanted_displacements(tmp_path, last_mm, expected):
    run = RunFiles.read(write_run(tmp_path / "run", last_mm=last_mm))
    chosen = [1e3 * row["displacement_m"] for row in chosen_snapshots(run) if row is not None]
    assert chosen == pytest.approx(expected)


def test_critical_simple_shear_angle_of_sand():
    assert critical_simple_shear_angle_deg(30.0) == pytest.approx(29.431, abs=5e-4)
