"""The two figures of a comparison."""

from itertools import product
from pathlib import Path

import numpy as np

from taichi_silo.runs.result import Result
from taichi_silo.show.figures.compare import LABELS, compare_forces_figure, compare_walls_figure, save
from taichi_silo.show.figures.wall_stress import STATES, STRESSES
from taichi_silo.show.report.states import FORCES, wall_profile
from taichi_silo.show.theory import janssen, pressure_ratios, wall_angle_deg
from taichi_silo.studies.compare.deviation import curve
from taichi_silo.studies.compare.measured import Measured


def draw(runs: list[Result], measured: list[Measured], with_janssen: bool, target: Path) -> list[Path]:
    """Draw `compare_forces.png` and `compare_walls.png` into a folder, and return those that have data.

    Places are those of the measured curves; without any, displacements, or times since the outflow began if a run
    falls freely.
    """
    taken = {one.place for one in measured if one.kind == "curves"}
    place = taken.pop() if taken else "time_s" if any(run.free for run in runs) else "displacement_m"
    time = place == "time_s"
    curves = {run.label: {name: curve(run, name, place) for name in LABELS} for run in runs}
    profiles = {run.label: {key: _walls(run, *key) for key in product(STATES, STRESSES)} for run in runs}
    top = max(run.scene.silo.height_m for run in runs)
    forces = {run.label: _forces(run) for run in runs} if with_janssen else {}
    stresses = {run.label: found for run in runs if (found := _stresses(run))} if with_janssen else {}
    figures = {
        "compare_forces.png": lambda: compare_forces_figure(curves, list(_points(measured, place)), forces, time),
        "compare_walls.png": lambda: compare_walls_figure(profiles, list(_profiles(measured)), stresses, top),
    }
    return save(figures, target)


def _walls(run: Result, state: str, column: str) -> dict:
    """Profiles of the walls that have to be told apart."""
    walls = ("left", "right") if run.lopsided else ("both",)
    return {wall: wall_profile(run, state, column, wall) for wall in walls}


def _points(measured: list[Measured], place: str):
    """Measured curves against this place."""
    for one in measured:
        if one.kind == "curves" and one.place == place:
            for name in one.quantities:
                known = one.table[[place, name]].dropna().to_numpy(float).T
                yield one.name, name, *known


def _profiles(measured: list[Measured]):
    for one in measured:
        if one.kind != "profile":
            continue
        for (state, wall), rows in one.table.groupby(["state", "wall"], sort=False):
            for name in one.quantities:
                known = rows[["height_m", name]].dropna().to_numpy(float).T
                yield one.name, state, name, wall, *known


def _forces(run: Result) -> dict[str, float | None]:
    """Janssen's P, T, N [N/m] at the law's own pressure ratio, and the angle of smooth walls."""
    theory = run.summary.get("janssen") or {}
    found = {name: theory.get(f"{FORCES[name][0]}_K0") for name in ("P", "T", "N")}
    return found | {"angle": wall_angle_deg(run) if run.scene.walls.kind == "smooth" else None}


def _stresses(run: Result) -> dict:
    """Janssen's profiles at the law's own pressure ratio; empty where the run does not say enough."""
    fill = janssen(run, next(iter(pressure_ratios(run).values())))
    if fill is None:
        return {}
    depth = np.linspace(0.0, fill.height_m, 101)
    height = run.scene.silo.height_m - depth
    return {
        "normal_stress_Pa": (height, fill.normal_stress_Pa(depth)),
        "shear_stress_Pa": (height, fill.shear_stress_Pa(depth)),
    }
