"""Shear zones inside the body: number, thickness, inclination, curvature, branching, and change of volume.

The shear strain (its path length, or its rate) is brought onto a raster of half the point spacing and its ridge lines
are found (`ridges`). Each arm of a ridge line, from end to end or to the place where it branches, is a zone. It is
measured in stations, one a spacing, along its normals, from the points themselves: with the excess of the strain over
the body's median, the thickness t_s is the width where the excess is above half of its peak, and the zone's
middle the centroid of that part. At a wall a zone ends.

Known limits:

- Zones narrower than two spacings read 1 to 2 spacings; nothing thinner than about one can be read.
- Parallel zones whose middles are nearer than 1.2 thicknesses, or than three times `SMOOTH`, are one; zones thicker
  than ten times `SMOOTH` may break up in noise.
- Ridges within `WALL_CLEAR` of a wall are left out: `wall_zone_thickness_m` measures the zones along walls. Zones that
  reach this strip are prolonged straight on to the wall, so a bent zone's height there is off by about
  curvature * strip^2.
- Zones shorter than four times `SMOOTH`, shorter than thick, or weaker than 0.15 of the strongest are not seen.
- Branching points are found to about half a thickness; those nearer than four times `SMOOTH` to each other are one.
- The curvature's error is up to 8 spacings / length^2; of a short straight zone it is not zero.
- The excess is over one background for the whole body. Where the strain also varies widely with height (the rate near
  an outlet), zones far from the strongest place fall below the threshold.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichi_silo.analysis.measure.raster import Raster, clean, point_spacing_m
from taichi_silo.analysis.measure.ridges import crest, ridges
from taichi_silo.analysis.measure.zone import CELLS, Body, Zone, measured_zone

HEIGHTS = (0.05, 0.9)  # of the body: lowest and highest place of ridges
THRESHOLD = 0.15  # of the strongest zone's excess: zones are several times as strong near the walls as on the axis
CONTRAST = 1.0  # of the strongest excess to the background, below which there is no zone
SMOOTH = 0.02  # of the width: standard deviation of the bell that ridges are found with; a spacing at least
SHORTEST = 4.0  # of these standard deviations
WALL_CLEAR = 0.125  # of the width, three spacings at least: wider than zones along walls, whose strain is far greater
MEETING = 2.0  # spacings between the ends of two zones on a wall, up to which they meet there


@dataclass(frozen=True)
class Zones:
    """All shear zones of a body."""

    count: int  # of connected ridge lines
    zones: tuple[Zone, ...]  # arms of the ridge lines, the longest first
    branching_m: NDArray  # (m, 2) places inside where three zones or more meet
    wall_branching_m: NDArray  # (k, 2) places on a wall where two zones meet it
    background: float  # median strain of the body
    spacing_m: float  # of the points


def shear_zones(
    position: NDArray,
    shear_strain: NDArray,
    width_m: float,
    void_ratio_change: NDArray | None = None,
    spacing_m: float | None = None,
    d50_m: float = np.nan,
    internal_length_m: float = np.nan,
) -> Zones:
    """Find and measure the shear zones inside the body.

    Parameters
    ----------
    position : (n, 2) places between the walls x = 0 and x = width [m].
    shear_strain : (n,) path length of the strain, its norm, or that of its rate; not negative.
    width_m : distance of the walls [m].
    void_ratio_change : (n,) void ratio less that after filling, optional.
    spacing_m : of the points; the distance to the nearest four, if not told.
    d50_m, internal_length_m : lengths that thicknesses are divided by.

    Raises ValueError if the width is not positive, lengths of arrays differ, or there are fewer than 25 points.
    """
    if not width_m > 0.0:
        raise ValueError(f"width is {width_m}; it must be positive")
    given = [] if void_ratio_change is None else [void_ratio_change]
    points, strain, *change = clean(position, shear_strain, *given)
    if len(points) < 25:
        raise ValueError(f"shear zones need 25 points, there are {len(points)}")
    spacing = spacing_m or point_spacing_m(points)
    clear = max(WALL_CLEAR * width_m, 3.0 * spacing)
    background = float(np.median(strain))
    excess = strain - background
    raster = Raster.over(points, width_m, spacing, cells=CELLS)
    sigma = max(spacing, SMOOTH * width_m) / raster.cell_m
    smooth, on, curvature = crest(raster.of(excess), sigma)
    low, high = np.quantile(points[:, 1], (0.0, 0.995))
    row = (raster.y_m[:, None] - low) / (high - low)
    wall = np.minimum(raster.x_m, width_m - raster.x_m)[None, :]
    allowed = raster.inside & (row >= HEIGHTS[0]) & (row <= HEIGHTS[1]) & (wall >= clear) & on
    strongest = float(smooth[allowed].max(initial=0.0))
    if not strongest > 0.0 or strongest < CONTRAST * background:
        return Zones(0, (), np.empty((0, 2)), np.empty((0, 2)), background, spacing)
    allowed &= smooth >= THRESHOLD * strongest
    wide = np.maximum(smooth, 0.0, out=smooth)
    wide *= 8.0 * np.log(2.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        wide /= np.abs(curvature, out=curvature)
    np.sqrt(wide, out=wide)
    del curvature
    lines = ridges(
        allowed,
        close=round(sigma),
        shortest=round(SHORTEST * sigma),
        width=wide,
        keep=np.broadcast_to(wall < clear + spacing, wide.shape),
    )
    body = Body(raster.tree, excess, change[0] - np.median(change[0]) if change else None, spacing, width_m, clear)
    corner = np.array([raster.x_m[0], raster.y_m[0]])
    junctions = corner + lines.junctions[:, ::-1] * raster.cell_m
    measured = (
        measured_zone(body, corner + arm[:, ::-1] * raster.cell_m, component, ends, junctions, d50_m, internal_length_m)
        for arm, component, ends in zip(lines.arms, lines.component, lines.ends, strict=True)
    )
    found = sorted((zone for zone in measured if zone is not None), key=lambda zone: -zone.length_m)
    return Zones(lines.count, tuple(found), junctions, _on_walls(found, body), background, spacing)


def _on_walls(zones: list[Zone], body: Body) -> NDArray:
    """Places (k, 2) on the walls where two zones meet [m]."""
    found = []
    for place, met in ((0.0, [z.wall_left_m for z in zones]), (body.width, [z.wall_right_m for z in zones])):
        heights = np.sort([height for height in met if np.isfinite(height)])
        for low, high in zip(heights[:-1], heights[1:], strict=True):
            if high - low <= MEETING * body.spacing:
                found.append((place, 0.5 * (low + high)))
    return np.array(found).reshape(-1, 2)
