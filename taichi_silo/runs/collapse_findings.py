"""How a column of sand has spread: run-out, height and slope, from the stored states of a run.

Lengths as Lube et al. (Phys. Rev. E 72 (2005) 041301) count them: L0 is the breadth of a column against one wall, half
the breadth of one that spreads to both sides; L is that length at a time, the mean of both sides.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.surface_profile import SurfaceProfile
from taichi_silo.runs.result import COLLAPSE, Result
from taichi_silo.scene import fill_shape
from taichi_silo.scene.scene import Scene
from taichi_silo.utils import atomic_write


def profile_of(points: dict[str, np.ndarray], scene: Scene) -> SurfaceProfile:
    """The free surface of a state of the points, on strips one spacing of the points wide."""
    wide, d = scene.silo.width_m, scene.spacing_m
    return SurfaceProfile.of(points["position"][:, 0], points["volume"], d, 0.0, wide, round(wide / d))


def first_length_m(scene: Scene) -> float:
    """L0 [m]."""
    left, right = fill_shape.sides_m(scene.silo)
    return (right - left) / max(1, sum(fill_shape.free_walls(scene.silo)))


def run_outs_m(profile: SurfaceProfile, scene: Scene) -> tuple[float, float]:
    """How far the left and the right front have run [m]; 0 where a wall of the silo is."""
    left, right = fill_shape.sides_m(scene.silo)
    first, last = profile.fronts_m(0.5 * (left + right))
    free = fill_shape.free_walls(scene.silo)
    return (left - first if free[0] else 0.0), (last - right if free[1] else 0.0)


def history(run: Result) -> pd.DataFrame:
    """A row for each stored state of the flow: time since the walls were taken away, fronts, height, energy."""
    scene, rows = run.scene, []
    states = run.snapshots[run.snapshots.file.str.startswith("filled") | (run.snapshots.stage == "flow")]
    for number, row in states.iterrows():
        points = run.state(int(number))
        profile = profile_of(points, scene)
        mass, speed = points["mass"], points["velocity"]
        if scene.silo.section == "round":  # per metre of the point's own girth, of the silo's instead
            mass = mass * np.abs(points["position"][:, 0] / (0.5 * scene.silo.width_m) - 1.0)
        gravity = scene.method.gravity_m_per_s2
        left, right = run_outs_m(profile, scene)
        rows.append(
            {
                "time_s": row["time_s"] - run.flow_start_s,
                "left_run_out_m": left,
                "right_run_out_m": right,
                "run_out_over_L0": (left + right)
                / (max(1, sum(fill_shape.free_walls(scene.silo))) * first_length_m(scene)),
                "height_m": profile.top_m,
                "potential_energy_J_per_m": gravity * float(mass @ points["position"][:, 1]),
                "kinetic_energy_J_per_m": 0.5 * float(mass @ (speed**2).sum(axis=1)),
                "mass_kg_per_m": float(mass.sum()),
            }
        )
    return pd.DataFrame(rows)


def collapse_findings(folder: Path) -> dict[str, Any]:
    """Write the history into `collapse.csv`, and give what it comes to at its end, for the summary."""
    run = Result(folder)
    table, scene = history(run), run.scene
    with atomic_write.written(folder / COLLAPSE) as passing:
        table.to_csv(passing, index=False, float_format="%.9g", lineterminator="\n")
    last, length = table.iloc[-1], first_length_m(scene)
    high = scene.silo.height_m
    arrived = table.run_out_over_L0 >= 0.99 * last.run_out_over_L0
    lost = 1.0 - (last.potential_energy_J_per_m + last.kinetic_energy_J_per_m) / table.potential_energy_J_per_m[0]
    return {
        "aspect_ratio": high / length,
        "first_length_m": length,
        "run_out_over_L0": float(last.run_out_over_L0),
        "height_m": float(last.height_m),
        "height_over_L0": float(last.height_m / length),
        "slope_deg": profile_of(run.state(-1), scene).slope_deg(),
        "front_at_rest_after_s": float(table.time_s[arrived].iloc[0]),
        "kinetic_energy_over_first_potential": float(last.kinetic_energy_J_per_m / table.potential_energy_J_per_m[0]),
        "energy_dissipated_over_first_potential": float(lost),
        "reached_a_wall": bool(_reached(run, scene)),
    }


def _reached(run: Result, scene: Scene) -> bool:
    """Whether a front has come to a wall of the silo."""
    left, right = profile_of(run.state(-1), scene).fronts_m(float(np.mean(fill_shape.sides_m(scene.silo))))
    free, near = fill_shape.free_walls(scene.silo), scene.spacing_m
    return (free[0] and left < near) or (free[1] and right > scene.silo.width_m - near)
