"""Residence times: how long the sand of a silo still takes to the outlet, if the flow goes on as it is.

The velocity field is taken as steady. Each point is followed along it to the outlet; the times are divided by that of
plug flow, area of the sand over outflow, in which a silo that moves as one block empties. In mass flow without shear
they grow evenly with height from 0 to 1.

What to read: as long as no sand from the surface has arrived, every steady flow without change of volume lets out as
much in the same time, so the low quantiles tell little. The tail does, and so do the sand that never leaves and
`first_from_surface`, which is 1 in plug flow and small where a fast channel draws sand from the surface.

Known limits: the field is that of one moment or interval, so a channel that widens while the silo empties is not
followed, and times beyond 1 hold for a silo that is kept full. Velocities are bilinear on a raster of the point
spacing: shear narrower than two spacings is smeared, so that sand up to 1.5 spacings beside a moving channel leaves
with it, and streamlines that pass within a spacing of the outlet's edge may miss it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichi_silo.analysis.measure.raster import Raster, clean

QUANTILES = (0.1, 0.25, 0.5, 0.75, 0.9)
LONGEST = 20.0  # plug-flow times; what has not left by then never leaves (mean speed below 1/20 of plug flow's)
STRIDE = 0.25  # of a cell: length of a step along a streamline
LONGEST_PATH = 6.0  # of width + height
AT_ONCE = 1 << 17  # points that are followed at once


@dataclass(frozen=True)
class Residence:
    """Times to the outlet."""

    plug_time_s: float  # area of the sand over outflow
    quantiles: tuple[float, ...]  # levels of `over_plug`
    over_plug: tuple[float, ...]  # by volume, of time over plug-flow time of the sand that leaves; nan if none does
    never_share: float  # of the volume that never leaves
    first_from_surface: float  # shortest time over plug-flow time of the sand at the surface; inf if none of it leaves
    time_s: NDArray  # (n,) of each point given; inf where it never leaves, nan for points that are not finite


def residence(
    position: NDArray,
    velocity: NDArray,
    volume: NDArray,
    width_m: float,
    outflow_m2_per_s: float,
    outlet_m: tuple[float, float] | tuple[tuple[float, float], ...] | None = None,
) -> Residence:
    """Follow all points to the outlet.

    Parameters
    ----------
    position : (n, 2) places between the walls x = 0 and x = width, over the bottom y = 0 [m].
    velocity : (n, 2) in the same frame, upwards positive [m/s]; better a mean over an interval
        (`flow_pattern.mean_velocity`).
    volume : (n,) present volume of the points per metre run [m2].
    width_m : distance of the walls [m].
    outflow_m2_per_s : volume that leaves per metre run and second.
    outlet_m : (left, right) edges of the outlet [m], or of each of several; the whole width if not told.

    Raises ValueError if the width or the outflow is not positive, the outlet is empty or not between the walls, lengths
    of arrays differ, or there are fewer than four points.
    """
    outlets = np.reshape(outlet_m or (0.0, width_m), (-1, 2))
    if not width_m > 0.0 or not outflow_m2_per_s > 0.0:
        raise ValueError(f"width is {width_m} m, outflow {outflow_m2_per_s} m2/s; both must be positive")
    for left, right in outlets.tolist():
        if not 0.0 <= left < right <= width_m * (1.0 + 1e-12):
            raise ValueError(f"outlet is from {left} to {right} m; it must lie between 0 and {width_m} m")
    points, flow, volumes = clean(position, velocity, volume)
    if len(points) < 4:
        raise ValueError(f"residence times need four points, there are {len(points)}")
    spacing = float(np.sqrt(np.median(volumes)))
    raster = Raster.over(points, width_m, spacing, bottom_m=0.0)
    plug = float(volumes.sum() / outflow_m2_per_s)
    fields, time = [raster.of(flow[:, k]) for k in (0, 1)], np.empty(len(points))
    for begin in range(0, len(points), AT_ONCE):
        some = points[begin : begin + AT_ONCE]
        time[begin : begin + AT_ONCE] = _times(some, raster, fields, width_m, outlets, LONGEST * plug)

    leaves = np.isfinite(time)
    share = tuple(_quantile(time[leaves] / plug, volumes[leaves], level) for level in QUANTILES)
    surface = _at_surface(points, raster, spacing)
    everywhere = np.full(len(position), np.nan)
    given = np.isfinite(np.column_stack([np.asarray(position, float)[:, :2], velocity, volume])).all(axis=1)
    everywhere[given] = time
    never, first = float(volumes[~leaves].sum() / volumes.sum()), float(time[surface].min(initial=np.inf) / plug)
    return Residence(plug, QUANTILES, share, never, first, everywhere)


def _times(
    points: NDArray, raster: Raster, fields: list[NDArray], width_m: float, outlets: NDArray, longest_s: float
) -> NDArray:
    """Time of each point to the outlet [s], by the midpoint rule in steps of equal length; inf if it never comes."""
    place, time, arrival = points.copy(), np.zeros(len(points)), np.full(len(points), np.inf)
    on_way, step = np.arange(len(points)), STRIDE * raster.cell_m
    walls = (width_m, np.inf)  # which points are kept between, and above the bottom
    stands = step / longest_s  # slower than this a single step takes longer than the longest time

    def velocity(place: NDArray) -> NDArray:
        return np.stack([raster.at(field, place) for field in fields], axis=-1)

    for _ in range(int(LONGEST_PATH * (width_m + np.ptp(raster.y_m)) / step) + 1):
        here, v = place[on_way], velocity(place[on_way])
        interval = step / np.maximum(np.hypot(v[:, 0], v[:, 1]), stands)
        v = velocity(np.clip(here + 0.5 * interval[:, None] * v, 0.0, walls))
        there = here + interval[:, None] * v
        through = there[:, 1] < 0.0
        above = np.maximum(here[:, 1], 0.0)  # sand in the outlet has left
        part = np.where(through, above / np.maximum(above - there[:, 1], 1e-300), 1.0)
        crossing = here[:, 0] + part * (there[:, 0] - here[:, 0])
        # a streamline along the bottom is pushed back onto it until it comes to the outlet
        left, right = outlets.T
        out = through & ((crossing[:, None] >= left) & (crossing[:, None] <= right)).any(axis=1)
        arrival[on_way[out]] = (time[on_way] + part * interval)[out]
        time[on_way] += interval
        place[on_way] = np.clip(there, 0.0, walls)
        on_way = on_way[~out & (time[on_way] < longest_s)]
        if not len(on_way):
            break
    return np.where(arrival <= longest_s, arrival, np.inf)


def _at_surface(points: NDArray, raster: Raster, spacing: float) -> NDArray:
    """Whether points are within 1.5 spacings of the highest one of their column of cells."""
    column = np.clip((points[:, 0] / raster.cell_m).astype(int), 0, len(raster.x_m) - 1)
    highest = np.full(len(raster.x_m), -np.inf)
    np.maximum.at(highest, column, points[:, 1])
    return points[:, 1] > highest[column] - 1.5 * spacing


def _quantile(value: NDArray, weight: NDArray, level: float) -> float:
    """Weighted quantile, linear between the middles of the weights; nan of nothing."""
    if not len(value):
        return np.nan
    order = np.argsort(value, kind="stable")
    middle = np.cumsum(weight[order]) - 0.5 * weight[order]
    return float(np.interp(level * weight.sum(), middle, value[order]))
