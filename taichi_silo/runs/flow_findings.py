"""What a run's flow was like, for its summary: flow pattern, residence times, shear zones inside."""

from typing import Any

import numpy as np

from taichi_silo.analysis.measure.flow_pattern import flow_pattern, mean_velocity
from taichi_silo.analysis.measure.matching import matched
from taichi_silo.analysis.measure.residence import residence
from taichi_silo.analysis.measure.zones import shear_zones
from taichi_silo.scene import known_limits
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.silo import Silo

FEWEST = 25  # points for any of these measures


def flow_findings(filled: dict, before: dict, now: dict, scene: Scene) -> dict:
    """Measure the flow between two states.

    Parameters
    ----------
    filled : the state that the flow started from.
    before, now : the two states: `Simulation.points` plus `displacement_m`, `time_s`, `sunk_m` (how far the bottom has
        sunk) and `left_m2` (area of sand that has left since `filled`).
    scene : of the run.

    """
    if len(now["mass"]) < FEWEST or not now["time_s"] > before["time_s"]:
        return {}
    found = _between(before, now, scene)
    since = since_filling(filled, now)
    del filled, before, now  # of a large silo there is no room for all at once
    return found | {"zones_inside": zones_inside(*since, scene)}


def _between(before: dict, now: dict, scene: Scene) -> dict:
    """Pattern and residence times of the flow from one state to the other."""
    seconds = now["time_s"] - before["time_s"]
    silo: Silo = scene.silo
    found: dict[str, Any] = {}
    then, here = (state["position"] + (0.0, state["sunk_m"]) for state in (before, now))
    origin = np.array([0.0, (now["sunk_m"] - before["sunk_m"]) / seconds])
    place, velocity, index = mean_velocity(then, here, seconds, before["identity"], now["identity"])
    del then, here
    velocity -= origin  # in the laboratory
    volume, breadth = before["volume"][index], silo.width_m
    if silo.section == "round":  # volumes are per metre of a point's own girth, the outflow per metre of the wall's
        breadth = 0.5 * silo.width_m
        volume = volume * np.abs(place[:, 0] - breadth) / breadth
    outflow = (now["left_m2"] - before["left_m2"]) / seconds
    height = float(np.quantile(place[:, 1], 0.99))
    if not known_limits.has_pattern(scene, now["displacement_m"]):
        outflow = 0.0
    if outflow > 0.0:
        pattern = flow_pattern(place, velocity, volume, silo.width_m, height, outflow / breadth)
        found["flow_pattern"] = {
            "kind": pattern.kind,
            "transition_left_m": pattern.transition_left_m,
            "transition_right_m": pattern.transition_right_m,
            "stagnant_area_share": pattern.stagnant_area_share,
            "between_s": [before["time_s"], now["time_s"]],
        }
    in_floor = all(one.in_floor for one in silo.openings)
    if outflow > 0.0 and in_floor and silo.has_opening:  # sand on a bottom that sinks as a whole stays on it
        outlets = tuple((one.low, one.high) for one in silo.openings)
        stay = residence(place, velocity, volume, silo.width_m, outflow, outlets)
        found["residence"] = {
            "plug_time_s": stay.plug_time_s,
            "over_plug": dict(zip([f"{level:g}" for level in stay.quantiles], stay.over_plug, strict=True)),
            "never_share": stay.never_share,
            "first_from_surface_over_plug": stay.first_from_surface,
        }
    return found


def since_filling(filled: dict, now: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places above the bottom now, path of the strain since filling, and change of the void ratio."""
    then, place = matched(filled, now), now["position"] + (0.0, now["sunk_m"])
    return place, np.maximum(now["path"] - then["path"], 0.0), now["void_ratio"] - then["void_ratio"]


def zones_inside(place: np.ndarray, path: np.ndarray, change: np.ndarray, scene: Scene) -> dict:
    """Number, thickness, curvature, branching of the shear zones inside, from what `since_filling` tells."""
    found = shear_zones(
        place, path, scene.silo.width_m, change, scene.spacing_m, scene.sand.d50_m,
        scene.characteristic_length_m or np.nan,
    )  # fmt: skip
    return {
        "count": found.count,
        "branching_points": len(found.branching_m),
        "branching_points_on_walls": len(found.wall_branching_m),
        "zones": [
            {
                "length_m": zone.length_m,
                "thickness_m": zone.thickness_m.median,
                "thickness_over_d50": zone.thickness_over_d50,
                "thickness_over_characteristic_length": zone.thickness_over_internal_length,
                "inclination_deg": zone.inclination_deg.median,
                "curvature_1_per_m": zone.curvature_1_per_m,
                "kind": zone.kind,
                "wall_left_m": zone.wall_left_m,
                "wall_right_m": zone.wall_right_m,
            }
            for zone in found.zones
        ],
    }
