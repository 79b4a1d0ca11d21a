"""Stresses on a hopper's walls, beside Walker's theory."""

import numpy as np

from taichi_silo.analysis.measure.wall_pressure import cell_mean
from taichi_silo.errors import BadInput
from taichi_silo.runs.run_folder import MADE
from taichi_silo.runs.theories import hopper_of, janssen_of
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.figures.wall_stress import HOPPER_CELL_M
from taichi_silo.show.report.states import profile
from taichi_silo.show.report.tables import Table
from taichi_silo.show.report.words import NONE, kPa, mm

SHARES = (0.9, 0.7, 0.5, 0.3, 0.1)  # of the hopper's height


def hopper_table(run: RunFiles) -> Table | None:
    """Normal stresses on the inclined walls at some heights; None without a hopper or its profiles."""
    if run.silo.hopper is None or not len(profile(run, "filling", "hopper_left")[0]):
        return None
    theory = {state: _walker(run, state) for state in ("filling", "discharge")}
    head = ["height (mm)", "after filling", "Walker, filling", "in flow, N largest", "end of flow", "Walker, flow"]
    rows = []
    for share in SHARES:
        height = share * run.transition_m
        read = {state: _read(run, state, height) for state in ("filling", "maximum", "residual")}
        walker = {state: NONE if law is None else _at(law, height) for state, law in theory.items()}
        states = (read["filling"], walker["filling"], read["maximum"], read["residual"], walker["discharge"])
        rows.append((f"{1e3 * height:.0f}", *states))
    note = f"Normal stress in kPa on the inclined walls, mean of both over {mm(HOPPER_CELL_M)}; height over the outlet."
    limit = (run.summary.get("theory") or {}).get("walker_limit")
    return Table(tuple(head), tuple(rows), note + (f" Walker's theory does not hold here: {limit}." if limit else ""))


def _read(run: RunFiles, state: str, height_m: float) -> str:
    values = []
    for wall in ("hopper_left", "hopper_right"):
        height, stress = profile(run, state, wall)
        if len(height) > 1:
            values.append(np.interp(height_m, height, cell_mean(height, stress, HOPPER_CELL_M)))
    return kPa(float(np.mean(values))) if values else NONE


def _walker(run: RunFiles, state: str):
    """Walker's theory below Janssen's at the law's own pressure ratio; None where it does not hold."""
    known = run.summary.get("janssen") or {}
    angle, ratio = known.get("wall_friction_angle_deg"), known.get("pressure_ratio_K0")
    if not angle or not ratio or not 0.0 < angle < 90.0:
        return None
    try:
        scene = read_scene(run.folder / MADE, threads=1)
        above = float(janssen_of(scene, angle, ratio).vertical_stress_Pa(run.silo.height_m - run.transition_m))
        return hopper_of(scene, angle, ratio, above, state)
    except (BadInput, ValueError):  # values of another version, or beyond the theory
        return None


def _at(law, height_m: float) -> str:
    return kPa(float(law.normal_stress_Pa(law.outlet_height_m + height_m)))
