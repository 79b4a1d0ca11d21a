"""Janssen's theory beside the forces after filling, for a summary: at the law's own K0, and at the K in the sand."""

import math

import numpy as np

from taichi_silo.analysis.theory.banded_janssen import BandedJanssen
from taichi_silo.analysis.theory.janssen import pressure_ratio_from_normal_force
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene import fill_shape
from taichi_silo.scene.scene import Scene

PROFILE_BAND = (0.2, 0.8)  # of the height: where the pressure ratio is measured, away from surface and corner


def janssen_findings(scene: Scene, filling: dict, points: dict, above: dict[str, tuple[float, float]]) -> dict:
    """Theory at each pressure ratio K, and the relative difference of the run from it, where the theory is not 0.

    It stands for the part with vertical walls on both sides; without such a part only K0 is told.

    Parameters
    ----------
    scene : of the run.
    filling : forces after filling, under the names of the summary.
    points : state of the points then.
    above : normal and shear force then of "left" and "right" wall above the higher of their feet [N/m].

    """
    silo, straight, angle = scene.silo, scene.silo.straight_m, scene.walls.friction_angle_deg
    forces = {name: filling[name] for name in ("normal_N_per_m", "shear_N_per_m", "bottom_N_per_m")}
    if silo.one_sided:
        forces["normal_N_per_m"], forces["shear_N_per_m"] = np.mean(list(above.values()), axis=0).tolist()
    if angle is None:  # of very rough walls what they mobilise
        angle = filling["wall_friction_angle_deg"] if straight else math.nan
        if silo.one_sided:
            angle = math.degrees(math.atan2(forces["shear_N_per_m"], forces["normal_N_per_m"]))
    bands = janssen_of(scene, 0.0, scene.law.rest_pressure_ratio(scene.sand.void_ratio)) if straight else None
    if isinstance(bands, BandedJanssen):
        angle = bands.wall_friction_angle_deg
    found = {
        "wall_friction_angle_deg": angle,
        "pressure_ratio_K0": scene.law.rest_pressure_ratio(scene.sand.void_ratio),
        "pressure_ratio_measured": measured_pressure_ratio(points, scene),
    }
    if not straight:  # inclined walls up to the surface
        return found
    density, normal = scene.density_kg_per_m3 * scene.method.gravity_m_per_s2, forces["normal_N_per_m"]
    try:
        found["pressure_ratio_fitted"] = (
            bands.fitted(normal)
            if isinstance(bands, BandedJanssen)
            else float(pressure_ratio_from_normal_force(normal, silo.width_m, straight, density, angle, silo.section))
        )
    except ValueError:  # no pressure ratio gives this force: a wall without contact, or a fill that hangs
        found["pressure_ratio_fitted"] = None
    if silo.one_sided:
        names = ("normal_N_per_m", "shear_N_per_m")
        found["above_m"] = silo.transition_m
        found["walls"] = {wall: dict(zip(names, values, strict=True)) for wall, values in above.items()}
    for key in ("K0", "measured"):
        if not (found[f"pressure_ratio_{key}"] > 0.0 and 0.0 <= angle < 90.0):
            continue
        theory = janssen_of(scene, angle, found[f"pressure_ratio_{key}"])
        values = {"normal_N_per_m": theory.normal_force_N_per_m, "shear_N_per_m": theory.shear_force_N_per_m}
        if not silo.transition_m:  # of a round silo two metres of girth are counted
            values["bottom_N_per_m"] = theory.bottom_force_N_per_m * (2 if silo.section == "round" else 1)
        for name, value in values.items():
            found[f"{name}_{key}"] = float(value)
            if value:  # walls without friction carry nothing
                found[f"{name}_{key}_relative_difference"] = float(forces[name] / value - 1.0)
    return found


def measured_pressure_ratio(points: dict, scene: Scene) -> float:
    """K: mean horizontal stress of the points next to the walls over the mean vertical stress in the same band."""
    x, y = points["position"].T
    horizontal, vertical = -points["stress"][:, 0], -points["stress"][:, 1]
    low, high = (share * fill_shape.lowest_m(scene.silo) for share in PROFILE_BAND)
    low = max(low, scene.silo.transition_m)
    band = (y > low) & (y < high)
    left, right = fill_shape.sides_m(scene.silo)
    wall = band & ((x < left + scene.spacing_m) | (x > right - scene.spacing_m))
    if not wall.any():
        return float("nan")
    weights = points["volume"][band]
    if scene.silo.section == "round":  # volumes are per metre of the point's own girth
        weights = weights * np.abs(x[band] - 0.5 * scene.silo.width_m)
    return float(horizontal[wall].mean() / np.average(vertical[band], weights=weights))
