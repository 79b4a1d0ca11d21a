"""Shear zones, read from the void ratio: thickness along a wall, and number of zones across the silo's axis.

Sand that is sheared to its critical state changes its void ratio: dense sand dilates, loose sand contracts. A
zone is therefore bounded where the change has fallen to half of its extreme value, as a
half-width at half-maximum. Positions are (x, y) in metres with the left wall at x = 0 and the right one at
x = width; heights are counted in the frame of the positions.

Known limits: a zone narrower than the point spacing d reads between d/2 and d; the numbers are not defined at
the free surface and at the bottom, which `HEIGHTS` and `AXIS_HEIGHTS` leave out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from taichi_silo.analysis.measure.peaks import peaks
from taichi_silo.analysis.measure.raster import (
    by_rows,
    clean,
    crossings,
    first_fall,
    inverse_distance_mean,
    median_distance,
)

SMALLEST_CHANGE = 0.01  # of the void ratio; anything below is no zone
HEIGHTS = (0.1, 0.8)  # of the fill height: lowest and highest row that is measured beside a wall
AXIS_HEIGHTS = (0.05, 0.85)  # the same on the axis; zones cut by an end are lost
REACH = 0.1  # of the width: how far from the wall the peak may lie


@dataclass(frozen=True)
class WallZone:
    """Thickness of the zone along one wall, over the rows of points: 0 if there is no zone, nan if there is no row."""

    median_m: float
    lower_quartile_m: float
    upper_quartile_m: float
    height_m: NDArray  # (rows,)
    thickness_m: NDArray  # (rows,) 0 in a row without a zone
    contractant: bool  # whether the void ratio falls in the zone (median row); False if there is no zone


@dataclass(frozen=True)
class InteriorZones:
    """Dilatant zones that cross the silo's axis: their number, and the height of each crossing [m]."""

    count: int
    height_m: NDArray


def wall_zone_thickness_m(
    position: NDArray, void_ratio: NDArray, void_ratio_reference: NDArray, width_m: float, side: str = "left"
) -> WallZone:
    """Return the thickness of the vertical zone along the wall of a side, "left" or "right".

    In each row of points the change c(x) = (e - e_ref) - (its median over the middle half of the row) is
    taken, so that a uniform loosening of the whole fill is not counted. Its extreme value c_peak is sought
    within `REACH` of the wall; below `SMALLEST_CHANGE` there is no zone, thickness 0. The thickness is the distance
    from the wall to the first place behind the peak where c / c_peak has fallen to half, with linear interpolation;
    half the silo's width if it never does. Positions are (n, 2) [m], void ratios (n,), the reference that after
    filling of the same points, or one number.
    """
    if side not in ("left", "right"):
        raise ValueError(f'side must be "left" or "right", got {side!r}')
    points, change = clean(position, np.asarray(void_ratio, float) - np.asarray(void_ratio_reference, float))
    if len(points) < 4:
        return WallZone(np.nan, np.nan, np.nan, np.empty(0), np.empty(0), False)
    spacing = _spacing(points)
    rows = _rows(points, HEIGHTS, spacing)
    distance = np.arange(0.5 * spacing, width_m - 0.5 * spacing, spacing / 8.0)
    field = _field(points, change, distance if side == "left" else width_m - distance, rows)
    field -= np.median(field[:, np.abs(distance - 0.5 * width_m) < 0.25 * width_m], axis=1, keepdims=True)

    near = distance <= max(REACH * width_m, 0.75 * spacing)
    peak = np.argmax(np.abs(field[:, near]), axis=1)
    value = np.take_along_axis(field, peak[:, None], axis=1)[:, 0]
    thickness = np.zeros(len(rows))
    for row in np.flatnonzero(np.abs(value) >= SMALLEST_CHANGE):
        relative = field[row, peak[row] :] / value[row]
        fall = first_fall(distance[peak[row] :], relative, 0.5, never=np.inf)
        thickness[row] = min(fall, 0.5 * width_m)
    if not len(rows):
        return WallZone(np.nan, np.nan, np.nan, rows, thickness, False)
    lower, median, upper = np.quantile(thickness, (0.25, 0.5, 0.75))
    contractant = bool(median > 0.0 and np.median(value) < 0.0)
    return WallZone(float(median), float(lower), float(upper), rows, thickness, contractant)


def interior_zone_count(
    position: NDArray,
    void_ratio: NDArray,
    width_m: float,
    threshold: float = 0.5,
    smallest_change: float = SMALLEST_CHANGE,
) -> InteriorZones:
    """Return how many dilatant zones are crossed on the way up the silo's axis, and where.

    The void ratio is averaged over a strip one point spacing to each side of the axis, row by row. With the
    background (median of this profile) and the band value (its maximum), a zone is a peak above
    background + rise, where rise = threshold (band - background), that also stands out of both its valleys by
    rise / 2 (its prominence). Zones less than `threshold` times as strong as the strongest one are thus not
    counted.

    Parameters
    ----------
    position : (n, 2) places of the points [m].
    void_ratio : (n,) [-].
    width_m : distance of the walls [m].
    threshold : strength, relative to the strongest zone, from which on a zone counts.
    smallest_change : no zone at all if band - background is below it.

    """
    points, void_ratio = clean(position, void_ratio)
    none = InteriorZones(0, np.empty(0))
    if len(points) < 4:
        return none
    spacing = _spacing(points)
    rows = _rows(points, AXIS_HEIGHTS, spacing, step=0.5 * spacing)
    if len(rows) < 3:
        return none
    strip = 0.5 * width_m + spacing * np.linspace(-1.0, 1.0, 9)
    profile = _field(points, void_ratio, strip, rows).mean(axis=1)
    background, band = np.median(profile), profile.max()
    if band - background < smallest_change:
        return none
    rise = threshold * (band - background)
    peak = peaks(profile, background + rise, 0.5 * rise)
    return InteriorZones(len(peak), rows[peak])


def _spacing(points: NDArray) -> float:
    """Distance to the nearest neighbour, median over the points [m]."""
    tree = cKDTree(points)
    distance = by_rows(lambda rows: tree.query(points[rows], k=[2])[0], len(points), 1)
    return float(np.median(distance))


def _rows(points: NDArray, heights: tuple[float, float], spacing: float, step: float | None = None) -> NDArray:
    """Heights [m] at every `step` (the spacing if not given) within fractions of the fill height."""
    bottom, top = points[:, 1].min() - 0.5 * spacing, np.quantile(points[:, 1], 0.99) + 0.5 * spacing
    low, high = (bottom + fraction * (top - bottom) for fraction in heights)
    return np.arange(low, high, step or spacing)


def _field(points: NDArray, value: NDArray, x: NDArray, y: NDArray) -> NDArray:
    """Values (len(y), len(x)) of the field at the crossings of columns x and rows y."""
    tree = cKDTree(points)
    typical_m = median_distance(tree, x, y, 4) if len(y) else 0.0
    return by_rows(lambda rows: inverse_distance_mean(tree, value, crossings(x, y[rows]), 4, typical_m), len(y), len(x))
