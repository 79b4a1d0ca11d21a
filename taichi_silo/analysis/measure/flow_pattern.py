"""Flow pattern of a discharging silo: mass, mixed or funnel flow, from the velocities of the points.

After EN 1991-4 (1.5): in mass flow all the stored sand moves, also along the walls; in mixed flow the flow channel
meets the wall below the free surface, at the effective transition; in funnel flow (pipe flow there) it does not, and
sand next to the wall stands still from the bottom to the surface.

Speeds are divided by the reference speed, the mean downward speed over the section = outflow of volume / width. The
walls stand at x = 0 and x = width and the bottom is at y = 0, so a moving bottom's displacement has to be added to
the positions; velocities are those of the laboratory. Mean velocities over an interval in which sand moves by a few
spacings (`mean_velocity`) tell more than those of one moment, which carry the oscillations of the column.

Known limits: walls are vertical. Speeds next to the wall are means over a layer of 0.05 widths (two spacings at
least) and as much height; so

- where the speed jumps with height, the transition is placed up to half that height off;
- a channel whose boundary closes in on the wall meets it where it enters the layer, lower than at the wall itself by
  0.9 layers times the boundary's slope;
- a dead corner lower than half that height is not seen.

Where the speed jumps across the channel's boundary, the boundary is found up to 1.5 spacings outside. A reference
speed that changes with time (free outflow) must be that of the same interval.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichi_silo.analysis.measure.raster import Raster, clean, first_fall
from taichi_silo.analysis.measure.wall_pressure import SURFACE

MOVES = 0.1  # of the reference speed, from which on sand moves
STAGNANT = 0.05  # of the reference speed: while the fill's own volume runs out, such sand sinks 1/20 of the height
LAYER = 0.05  # of the width: thickness and height of the part of the wall layer that a speed is the mean of


@dataclass(frozen=True)
class FlowPattern:
    """Pattern of a flow, and the boundary of its channel: where the downward speed falls to the threshold.

    The boundary is sought on both sides of the fastest place of a row; it is 0 or the width where the speed does not
    fall before the wall, and nan in rows in which nothing moves.
    """

    kind: str  # "mass", "mixed" or "funnel"; mixed is all between, also one wall with, the other without transition
    transition_left_m: float  # lowest height above which, up to the surface, all sand next to the wall moves
    transition_right_m: float  # 0 if that is everywhere, nan if it never is
    stagnant_area_share: float  # of the volume that is slower than 0.05 reference speeds, in any direction
    height_m: NDArray  # (rows,) of the channel's boundary
    x_left_m: NDArray  # (rows,)
    x_right_m: NDArray  # (rows,)


def mean_velocity(
    before: NDArray, after: NDArray, interval_s: float, identity_before: NDArray, identity_after: NDArray
) -> tuple[NDArray, NDArray, NDArray]:
    """Half-way place (k, 2) [m], mean velocity (k, 2) [m/s] and index in `before` (k,) of points in two snapshots.

    `before` and `after` are positions (n, 2) and (m, 2) in the laboratory [m]; an identity is a number that a point
    keeps. Raises ValueError if the interval is not positive.
    """
    if not interval_s > 0.0:
        raise ValueError(f"interval is {interval_s} s; it must be positive")
    _, index, other = np.intersect1d(identity_before, identity_after, assume_unique=True, return_indices=True)
    start, end = before[index], after[other]
    return 0.5 * (start + end), (end - start) / interval_s, index


def flow_pattern(
    position: NDArray,
    velocity: NDArray,
    volume: NDArray,
    width_m: float,
    fill_height_m: float,
    reference_speed_m_per_s: float,
    threshold: float = MOVES,
) -> FlowPattern:
    """Measure the flow pattern.

    Parameters
    ----------
    position : (n, 2) places over the bottom [m].
    velocity : (n, 2) in the laboratory, upwards positive [m/s].
    volume : (n,) present volume of the points per metre run [m2].
    width_m : distance of the walls [m].
    fill_height_m : height of the fill over the bottom now [m].
    reference_speed_m_per_s : outflow of volume per metre run over the width.
    threshold : downward speed over the reference speed from which on sand moves.

    Raises ValueError if a length or the reference speed is not positive, lengths of arrays differ, or there are fewer
    than four points.
    """
    for name, value in (("width", width_m), ("fill height", fill_height_m), ("speed", reference_speed_m_per_s)):
        if not value > 0.0:
            raise ValueError(f"{name} is {value}; it must be positive")
    points, velocity, volume = clean(position, velocity, volume)
    if len(points) < 4:
        raise ValueError(f"a flow pattern needs four points, there are {len(points)}")
    spacing = float(np.sqrt(np.median(volume)))
    relative = -velocity[:, 1] / reference_speed_m_per_s
    speed = np.hypot(*velocity.T) / reference_speed_m_per_s
    window = max(LAYER * width_m, 2.0 * spacing)
    top = SURFACE * fill_height_m
    left, right = (
        _transition(points[near, 1], relative[near], volume[near], window, top, threshold)
        for near in (points[:, 0] < window, points[:, 0] > width_m - window)
    )
    kind = "mass" if left == right == 0.0 else "funnel" if np.isnan(left) and np.isnan(right) else "mixed"
    stagnant = float(volume[speed < STAGNANT].sum() / volume.sum())
    return FlowPattern(
        kind, left, right, stagnant, *_channel(points, relative, width_m, spacing, window, top, threshold)
    )


def _transition(
    height: NDArray, relative: NDArray, volume: NDArray, window: float, top: float, threshold: float
) -> float:
    """Lowest height above which all means over windows of the wall layer reach the threshold."""
    middle = np.arange(0.5 * window, max(top, 0.6 * window), 0.125 * window)
    order = np.argsort(height, kind="stable")
    first, last = (np.searchsorted(height[order], middle + end * window) for end in (-0.5, 0.5))
    total, moved = np.diff(
        [np.insert(np.cumsum(part[order]), 0, 0.0)[[first, last]] for part in (volume, volume * relative)], axis=1
    )[:, 0]
    there = total > 0.0  # else the surface is lower at the wall, or there is a gap
    if not there.any():
        return np.nan
    middle, mean = middle[there], moved[there] / total[there]
    still = np.flatnonzero(mean < threshold)
    if not len(still):
        return 0.0
    k = still[-1]
    if k == len(middle) - 1:
        return np.nan
    share = (threshold - mean[k]) / (mean[k + 1] - mean[k])
    return float(middle[k] + share * (middle[k + 1] - middle[k]))


def _channel(
    points: NDArray, relative: NDArray, width_m: float, spacing: float, window: float, top: float, threshold: float
) -> tuple[NDArray, NDArray, NDArray]:
    """Heights of rows, and the channel's left and right boundary about the fastest place of each [m]."""
    raster = Raster.over(points, width_m, spacing, bottom_m=0.0, top_m=top)
    rows = 2 * int(0.5 * window / raster.cell_m) + 1
    from scipy.ndimage import uniform_filter1d  # it takes a tenth of a second

    field = uniform_filter1d(raster.of(relative), rows, axis=0, mode="nearest")
    left, right = np.full(len(field), np.nan), np.full(len(field), np.nan)
    there = raster.inside.any(axis=1)
    for row in np.flatnonzero(there & (field.max(axis=1) >= threshold)):
        fastest = int(np.argmax(field[row]))
        right[row] = first_fall(raster.x_m[fastest:], field[row, fastest:], threshold, never=width_m)
        left[row] = first_fall(raster.x_m[fastest::-1], field[row, fastest::-1], threshold, never=0.0)
    return raster.y_m, left, right
