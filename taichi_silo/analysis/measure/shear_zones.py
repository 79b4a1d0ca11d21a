"""Shear zones, read from the void ratio: thickness along a wall, and number of zones across the silo's axis.

Sand that is sheared to its critical state changes its void ratio: dense sand dilates, loose sand contracts. A
zone is therefore bounded where the change has fallen to half (`threshold`) of its extreme value, as a
half-width at half-maximum. Positions are (x, y) in metres with the left wall at x = 0 and the right one at
x = width; heights are counted in the frame of the positions.

Known limits: a zone narrower than the point spacing d reads between d/2 and d; the numbers are not defined at
the free surface and at the bottom, which the default `heights` leave out.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

SMALLEST_CHANGE = 0.01  # of the void ratio; anything below is no zone


@dataclass(frozen=True)
class WallZone:
    """Thickness of the zone along one wall.

    Attributes
    ----------
    median_m, lower_quartile_m, upper_quartile_m : float
        Thickness over the rows [m]: 0 if there is no zone, nan if there is no row to measure.
    height_m : (rows,) array
        Height of each row [m].
    thickness_m : (rows,) array
        Thickness in each row [m]; 0 in a row without a zone.
    contractant : bool
        True if the void ratio falls in the zone (median row), False if it grows or if there is no zone.
    """

    median_m: float
    lower_quartile_m: float
    upper_quartile_m: float
    height_m: np.ndarray
    thickness_m: np.ndarray
    contractant: bool


@dataclass(frozen=True)
class InteriorZones:
    """Dilatant zones that cross the silo's axis: their number, and the height of each crossing [m]."""

    count: int
    height_m: np.ndarray


def wall_zone_thickness_m(
    position,
    void_ratio,
    void_ratio_reference,
    width_m: float,
    side: str = "left",
    heights: tuple[float, float] = (0.1, 0.8),
    threshold: float = 0.5,
    reach: float = 0.1,
    smallest_change: float = SMALLEST_CHANGE,
) -> WallZone:
    """Return the thickness of the vertical zone along a wall.

    In each row of points the change c(x) = (e - e_ref) - (its median over the middle half of the row) is
    taken, so that a uniform loosening of the whole fill is not counted. Its extreme value c_peak is sought
    within `reach` of the wall. The thickness is the distance from the wall to the first place behind the peak
    where c / c_peak has fallen to `threshold`, with linear interpolation; half the silo's width if it never
    does.

    Parameters
    ----------
    position : (n, 2) array
        Points [m].
    void_ratio : (n,) array
        Void ratio now [-].
    void_ratio_reference : (n,) array or float
        Void ratio of the same points after filling [-].
    width_m : float
        Distance of the walls [m].
    side : "left" or "right"
        The wall.
    heights : (float, float)
        Lowest and highest row, as fractions of the fill height.
    threshold : float
        Fraction of the peak that bounds the zone.
    reach : float
        How far from the wall the peak may lie, as a fraction of the width.
    smallest_change : float
        A peak below it counts as no zone, thickness 0.
    """
    if side not in ("left", "right"):
        raise ValueError(f'side must be "left" or "right", got {side!r}')
    points, change = _clean(position, np.asarray(void_ratio, float) - np.asarray(void_ratio_reference, float))
    if len(points) < 4:
        return WallZone(np.nan, np.nan, np.nan, np.empty(0), np.empty(0), False)
    spacing = _spacing(points)
    rows = _rows(points, heights, spacing)
    distance = np.arange(0.5 * spacing, width_m - 0.5 * spacing, spacing / 8.0)
    field = _sample(points, change, distance if side == "left" else width_m - distance, rows)
    field -= np.median(field[:, np.abs(distance - 0.5 * width_m) < 0.25 * width_m], axis=1, keepdims=True)

    near = distance <= max(reach * width_m, 0.75 * spacing)
    peak = np.argmax(np.abs(field[:, near]), axis=1)
    value = np.take_along_axis(field, peak[:, None], axis=1)[:, 0]
    thickness = np.zeros(len(rows))
    for row in np.flatnonzero(np.abs(value) >= smallest_change):
        relative = field[row, peak[row] :] / value[row]
        thickness[row] = min(_first_fall(distance[peak[row] :], relative, threshold), 0.5 * width_m)
    if not len(rows):
        return WallZone(np.nan, np.nan, np.nan, rows, thickness, False)
    lower, median, upper = np.quantile(thickness, (0.25, 0.5, 0.75))
    contractant = bool(median > 0.0 and np.median(value) < 0.0)
    return WallZone(float(median), float(lower), float(upper), rows, thickness, contractant)


def interior_zone_count(
    position,
    void_ratio,
    width_m: float,
    heights: tuple[float, float] = (0.05, 0.85),
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
    position : (n, 2) array
        Points [m].
    void_ratio : (n,) array
        Void ratio [-].
    width_m : float
        Distance of the walls [m].
    heights : (float, float)
        Lowest and highest place on the axis, as fractions of the fill height; zones cut by an end are lost.
    threshold : float
        Strength, relative to the strongest zone, from which on a zone counts.
    smallest_change : float
        No zone at all if band - background is below it.
    """
    points, void_ratio = _clean(position, void_ratio)
    none = InteriorZones(0, np.empty(0))
    if len(points) < 4:
        return none
    spacing = _spacing(points)
    rows = _rows(points, heights, spacing, step=0.5 * spacing)
    if len(rows) < 3:
        return none
    strip = 0.5 * width_m + spacing * np.linspace(-1.0, 1.0, 9)
    profile = _sample(points, void_ratio, strip, rows).mean(axis=1)
    background, band = np.median(profile), profile.max()
    if band - background < smallest_change:
        return none
    rise = threshold * (band - background)
    from scipy.signal import find_peaks  # with it comes all of scipy.stats, for half a second

    peak, _ = find_peaks(profile, height=background + rise, prominence=0.5 * rise)
    return InteriorZones(len(peak), rows[peak])


def _clean(position, value):
    """Return the points (n, 2) and values (n,) that are finite."""
    position, value = np.asarray(position, float)[:, :2], np.asarray(value, float)
    finite = np.isfinite(position).all(axis=1) & np.isfinite(value)
    return position[finite], value[finite]


def _spacing(points) -> float:
    """Return the typical distance of neighbouring points [m]."""
    distance, _ = cKDTree(points).query(points, k=2)
    return float(np.median(distance[:, 1]))


def _rows(points, heights, spacing: float, step: float | None = None):
    """Return heights [m] at every `step` (default: the spacing) within fractions of the fill height."""
    bottom, top = points[:, 1].min() - 0.5 * spacing, np.quantile(points[:, 1], 0.99) + 0.5 * spacing
    low, high = (bottom + fraction * (top - bottom) for fraction in heights)
    return np.arange(low, high, step or spacing)


def _sample(points, value, x, y):
    """Return the field (len(y), len(x)): the four nearest points, weighted by 1 / distance^2."""
    distance, neighbour = cKDTree(points).query(np.stack(np.meshgrid(x, y), axis=-1), k=4)
    weight = 1.0 / (distance**2 + 1e-6 * np.median(distance) ** 2)  # finite on a point
    return np.sum(weight * value[neighbour], axis=-1) / np.sum(weight, axis=-1)


def _first_fall(distance, relative, threshold: float) -> float:
    """Return the distance at which `relative`, 1 at first, falls to the threshold; infinite if never."""
    below = np.flatnonzero(relative < threshold)
    if not len(below):
        return np.inf
    after, before = below[0], below[0] - 1
    share = (relative[before] - threshold) / (relative[before] - relative[after])
    return float(distance[before] + share * (distance[after] - distance[before]))
