"""Measures of a run's points: shear zones, loosening, and which sand moves.

Points leave the silo through an outlet; where their number has changed, the void ratio after filling is taken as its
mean over all points.
"""

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from taichi_silo.analysis.measure.void_ratio_zones import interior_zone_count, wall_zone_thickness_m
from validation.paper.files import CaseRun

RASTER_M = 0.001
WALL_ZONE_M = 0.02  # next to a wall: the interior begins behind it (the paper's thickest wall zone is 16 mm)
BESIDE_M = (0.015, 0.025)  # from a wall: sand there moves in mass flow, also at walls that sand sticks to
BIN_M = 0.02
STILL = 0.05  # of the outlet's speed: slower sand is dead
ABOVE_OUTLET_M = 0.1  # how high the region above an outlet is taken: half the silo's width
SMALLEST_ZONE = 0.03  # change of void ratio against the sand around it, below which nothing is a zone of the interior


def _reference(run: CaseRun, points):
    """Void ratio after filling: of each point, or the mean."""
    filled = run.points("filled")
    return filled["void_ratio"] if len(filled["mass"]) == len(points["mass"]) else float(filled["void_ratio"].mean())


def _change(run: CaseRun, when: str = "last"):
    points = run.points(when)
    return points, points["void_ratio"] - _reference(run, points)


def wall_zone_mm(run: CaseRun, wall: str = "left") -> float:
    """Thickness of the zone along a wall [mm] at the end, 0 if there is none."""
    points = run.points("last")
    zone = wall_zone_thickness_m(
        points["position"], points["void_ratio"], _reference(run, points), run.case.silo_width_m, side=wall
    )
    return 1e3 * zone.median_m


def wall_change(run: CaseRun, wall: str = "left") -> float:
    """Change of void ratio within 5 mm of a wall, less that of the core at the same heights (0.1 to 0.8)."""
    points, change = _change(run)
    x, y = points["position"].T
    width = run.case.silo_width_m
    distance = x if wall == "left" else width - x
    height = (y > 0.1 * run.case.silo_height_m) & (y < 0.8 * run.case.silo_height_m)
    near, core = height & (distance < 0.005), height & (np.abs(x - 0.5 * width) < 0.25 * width)
    if not near.any() or not core.any():
        return np.nan
    return float(change[near].mean() - np.median(change[core]))


def mean_change(run: CaseRun, begin: str = "filled", end: str = "last") -> float:
    """Change of the mean void ratio between two snapshots [-]."""
    return float(run.points(end)["void_ratio"].mean() - run.points(begin)["void_ratio"].mean())


def interior_zones(run: CaseRun) -> float:
    """Largest number of zones on three verticals, at 1/4, 1/2 and 3/4 of the width; dilatant or contractant ones."""
    points, width, most = run.points("last"), run.case.silo_width_m, 0
    for place in (0.25, 0.5, 0.75):
        moved = points["position"] + [(0.5 - place) * width, 0.0]
        for sign in (1.0, -1.0):
            found = interior_zone_count(moved, sign * points["void_ratio"], width, smallest_change=SMALLEST_ZONE)
            most = max(most, found.count)
    return float(most)


def interior_zone_mm(run: CaseRun) -> float:
    """Thickness of the dilatant zones of the interior [mm]: nan if there are none.

    The zones are the places whose void ratio has grown by half as much as in the strongest zone (98th percentile),
    beyond the median. In a band of thickness t the mean distance to its edge is t / 4.
    """
    points, change = _change(run)
    width, (low, high) = run.case.silo_width_m, (0.1 * run.case.silo_height_m, 0.85 * run.case.silo_height_m)
    x = np.arange(WALL_ZONE_M, width - WALL_ZONE_M, RASTER_M)
    y = np.arange(low, high, RASTER_M)
    distance, neighbour = cKDTree(points["position"]).query(np.stack(np.meshgrid(x, y), axis=-1), k=4)
    weight = 1.0 / (distance**2 + 1e-9)
    field = (weight * change[neighbour]).sum(axis=-1) / weight.sum(axis=-1)
    background, band = np.quantile(field, (0.5, 0.98))
    if band - background < SMALLEST_ZONE:
        return np.nan
    inside = distance_transform_edt(np.pad(field > 0.5 * (background + band), 1, mode="edge"))[1:-1, 1:-1]
    return float(4e3 * RASTER_M * inside[inside > 0.0].mean())


def sheared_change(run: CaseRun) -> float:
    """Mean change of void ratio of the most strongly sheared tenth of the interior sand."""
    points, change = _change(run)
    chosen = np.flatnonzero(_interior(run, points))
    if len(chosen) < 10:
        return np.nan
    strong = chosen[np.argsort(points["path"][chosen])][-(len(chosen) // 10) :]
    return float(change[strong].mean())


def sheared_height_mm(run: CaseRun) -> float:
    """Height [mm] below which 90 % of the strongly sheared points of the interior lie (half the 95th percentile)."""
    points = run.points("last")
    chosen = _interior(run, points)
    if chosen.sum() < 10:
        return np.nan
    strong = chosen & (points["path"] >= 0.5 * np.quantile(points["path"][chosen], 0.95))
    return float(1e3 * np.quantile(points["position"][strong, 1], 0.9))


def _interior(run: CaseRun, points):
    x, width = points["position"][:, 0], run.case.silo_width_m
    return (x > WALL_ZONE_M) & (x < width - WALL_ZONE_M)


def outlet_change(run: CaseRun) -> float:
    """Mean change of void ratio above the outlet, up to half the silo's width."""
    points, change = _change(run)
    x, y = points["position"].T
    opening = run.case.opening
    chosen = (x > opening.left_m) & (x < opening.right_m) & (y < ABOVE_OUTLET_M)
    return float(change[chosen].mean()) if chosen.any() else np.nan


def dead_share(run: CaseRun, wall: str = "either", above_mm: float = 0.0) -> float:
    """Share of a wall's height along which the sand is dead (the larger one with "either"), 0 to 1.

    The sand 15 to 25 mm from the wall, in bins of 20 mm of height; dead if its median speed at the last snapshot is
    below 5 % of the outlet's.
    """
    if wall == "either":
        return max(dead_share(run, side, above_mm) for side in ("left", "right"))
    points, speed = run.points("last"), run.outlet_speed
    x, y = points["position"].T
    distance = x if wall == "left" else run.case.silo_width_m - x
    beside = (distance > BESIDE_M[0]) & (distance < BESIDE_M[1]) & (y > 1e-3 * above_mm)
    if not beside.any() or not np.isfinite(speed):
        return np.nan
    floor = np.floor(y[beside] / BIN_M)
    fast = np.linalg.norm(points["velocity"][beside], axis=1)
    medians = [np.median(fast[floor == level]) for level in np.unique(floor)]
    return float(np.mean(np.array(medians) < STILL * speed))


def core_scatter(run: CaseRun) -> float:
    """Standard deviation over mean of how far the core's points sank between the last two snapshots.

    The core is the middle half of the width, between 0.1 and 0.9 of the height; 0 is a rigid body. nan if points left.
    """
    before, last = run.points("before"), run.points("last")
    if len(before["mass"]) != len(last["mass"]):
        return np.nan
    x, y = before["position"].T
    case = run.case
    core = (np.abs(x - 0.5 * case.silo_width_m) < 0.25 * case.silo_width_m) & (y > 0.1 * case.silo_height_m)
    core &= y < 0.9 * case.silo_height_m
    sunk = (before["position"] - last["position"])[core, 1]
    return float(sunk.std() / sunk.mean()) if len(sunk) and sunk.mean() > 0.0 else np.nan
