"""One shear zone, measured in stations along the middle of its ridge line; the definitions are in zones.py."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.spatial import cKDTree

from taichi_silo.analysis.measure.raster import by_rows, first_fall, sample, within
from taichi_silo.analysis.measure.void_ratio_zones import SMALLEST_CHANGE

CELLS = 2  # of the raster a spacing
ARRIVES = 3.0  # spacings, or a thickness: how far before the strip along a wall a zone that reaches it may end
REACH = 0.3  # of the width: how far the edges of a zone are sought
FINEST = 0.1  # spacings between the places of a profile


@dataclass(frozen=True)
class Spread:
    """Median and quartiles."""

    median: float
    lower: float
    upper: float

    @classmethod
    def of(cls, values: NDArray) -> "Spread":
        """Median and quartiles of the finite values; nan if there is none."""
        values = np.asarray(values, float)
        values = values[np.isfinite(values)]
        if not len(values):
            return cls(np.nan, np.nan, np.nan)
        return cls(*(float(v) for v in np.quantile(values, (0.5, 0.25, 0.75))))


@dataclass(frozen=True)
class Zone:
    """One zone; what is measured in stations is given over all of them."""

    component: int  # number of the connected ridge line it belongs to
    length_m: float  # along its middle
    thickness_m: Spread  # t_s, width at half the greatest excess
    thickness_over_d50: float  # of the median; nan without a mean grain diameter
    thickness_over_internal_length: float  # of the median, over l_c; nan without one
    strain: Spread  # greatest excess
    inclination_deg: Spread  # to the horizontal, rising to the right positive; the median is in (-90, 90]
    curvature_1_per_m: (
        float  # of the circle through the middles; positive if its centre lies above, negative for an arch
    )
    apex_curvature_1_per_m: float  # of the parabola along the chord, at its apex
    void_ratio_change: float  # mean over the zone in excess of the body's median; nan if not given
    kind: str  # "dilatant", "contractant", "neutral" (smaller than 0.01), or "unknown"
    wall_left_m: float  # height at which it meets the wall; nan if it does not
    wall_right_m: float
    middle_m: NDArray  # (k, 2)


@dataclass(frozen=True)
class Body:
    """The points that all zones are measured on."""

    tree: cKDTree  # of the points
    excess: NDArray  # (n,) shear strain less its median
    change: NDArray | None  # (n,) of the void ratio, less its median
    spacing: float  # of the points [m]
    width: float  # distance of the walls [m]
    clear: float  # width of the strip along the walls without ridges [m]


def measured_zone(
    body: Body,
    arm: NDArray,
    component: int,
    free: tuple[bool, bool],
    junctions: NDArray,
    d50_m: float,
    internal_length_m: float,
) -> Zone | None:
    """Measure an arm (k, 2) [m] of the ridge line number `component`; `free` says which of its ends are free.

    None if fewer than four stations are clear of the junctions (m, 2) [m], or the strain falls to half in none.
    """
    line, across = _stations(arm, body.spacing)
    offset = np.arange(-REACH, REACH, FINEST * body.spacing / body.width) * body.width
    offset -= offset[np.argmin(np.abs(offset))]

    def places(rows: slice) -> NDArray:
        return line[rows, None, :] + offset[None, :, None] * across[rows, None, :]

    def profiles(rows: slice) -> NDArray:
        there = places(rows)
        inside = within(body.tree, there, body.spacing) & (there[..., 0] >= 0.0) & (there[..., 0] <= body.width)
        return np.where(inside, sample(body.tree, body.excess, there, body.spacing), -np.inf)

    profile = by_rows(profiles, len(line), len(offset))
    middles, widths, peaks, parts = [], [], [], []
    near = np.flatnonzero(np.abs(offset) <= 1.5 * body.spacing)
    for values in profile:
        top = int(near[np.argmax(values[near])])
        sides = [_side(values[top::way], np.abs(offset[top::way] - offset[top])) for way in (-1, 1)]
        known = [side for side in sides if np.isfinite(side)]
        part = np.abs(offset - offset[top]) <= (min(known) if known else body.spacing)
        part &= np.isfinite(values)
        weight = np.maximum(values[part] - 0.5 * values[top], 0.0)
        middles.append(np.average(offset[part], weights=weight) if weight.sum() > 0.0 else offset[top])
        widths.append(2.0 * np.mean(known) if known else np.nan)
        peaks.append(values[top])
        parts.append(part)
    middle, thick, peak = line + np.array(middles)[:, None] * across, np.array(widths), np.array(peaks)
    # near a junction a section runs into the other arms
    typical = np.nanmedian(thick) if np.isfinite(thick).any() else body.spacing
    gap = np.full(len(line), np.inf)
    if len(junctions):
        gap = np.hypot(*(line[:, None] - junctions[None]).transpose(2, 0, 1)).min(axis=1)
    clear = gap > typical
    if clear.sum() < 4:
        clear[:] = True
    if clear.sum() < 4 or not np.isfinite(thick[clear]).any():
        return None
    middle, thickness = middle[clear], Spread.of(thick[clear])
    direction = chord(middle)[1]
    angle = inclinations_deg(middle, direction)
    inclination = Spread.of(angle - 180.0 * np.ceil((np.median(angle) - 90.0) / 180.0))
    change, kind = np.nan, "unknown"
    if body.change is not None:
        of_change = body.change
        values = by_rows(lambda rows: sample(body.tree, of_change, places(rows), body.spacing), len(line), len(offset))[
            clear
        ]
        change = float(np.mean(values[np.array(parts)[clear]]))
        kind = "neutral" if abs(change) < SMALLEST_CHANGE else "dilatant" if change > 0.0 else "contractant"
    left, right = _meets_walls(body, middle, free, thickness.median)
    return Zone(
        component=component,
        length_m=float(np.hypot(*np.diff(line, axis=0).T).sum()),
        thickness_m=thickness,
        thickness_over_d50=thickness.median / d50_m,
        thickness_over_internal_length=thickness.median / internal_length_m,
        strain=Spread.of(peak[clear]),
        inclination_deg=inclination,
        curvature_1_per_m=circle_curvature(middle),
        apex_curvature_1_per_m=parabola_curvature(middle),
        void_ratio_change=change,
        kind=kind,
        wall_left_m=left,
        wall_right_m=right,
        middle_m=middle,
    )


def _stations(arm: NDArray, spacing: float) -> tuple[NDArray, NDArray]:
    """Places at every spacing along an arm, and the normals there."""
    smooth = uniform_filter1d(arm.astype(float), 4 * CELLS + 1, axis=0, mode="nearest")
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(smooth, axis=0).T))])
    length, first = np.unique(length, return_index=True)
    count = max(2, round(length[-1] / spacing) + 1)
    line = np.column_stack([np.interp(np.linspace(0.0, length[-1], count), length, smooth[first, k]) for k in (0, 1)])
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-300)[:, None]
    return line, np.column_stack([-along[:, 1], along[:, 0]])


def _side(values: NDArray, distance: NDArray) -> float:
    """Distance at which a profile has fallen to half of its first value; nan if there is none, or it rises before."""
    half = 0.5 * values[0]
    below = np.flatnonzero(values < half)
    if not len(below) or below[0] == 0 or values[: below[0]].max() > 1.1 * values[0]:
        return np.nan
    after, before = below[0], below[0] - 1
    if not np.isfinite(values[after]):  # the wall or the surface
        return float(distance[before])
    return first_fall(distance, values, half, never=np.nan)


def _meets_walls(body: Body, middle: NDArray, free: tuple[bool, bool], thickness_m: float) -> tuple[float, float]:
    """Heights at which a zone, prolonged straight on, meets the left and the right wall; nan if it does not."""
    found = [np.nan, np.nan]
    reach = body.clear + max(ARRIVES * body.spacing, thickness_m)
    for ending, tip in zip(free, (middle[:5], middle[::-1][:5]), strict=True):
        for wall, place in enumerate((0.0, body.width)):
            distance = abs(tip[0, 0] - place)
            run = tip[0] - tip[-1]
            towards = run[0] * (place - tip[0, 0])
            if ending and distance <= reach and towards > 0.0:
                found[wall] = float(tip[0, 1] + run[1] / run[0] * (place - tip[0, 0]))
    return found[0], found[1]


# lines through points: inclination and curvature


def chord(points: NDArray) -> tuple[NDArray, NDArray]:
    """Middle of points (n, 2), and direction of the line through them, with x >= 0 (upwards if vertical)."""
    middle = points.mean(axis=0)
    along = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    if along[0] < -1e-12 or (abs(along[0]) <= 1e-12 and along[1] < 0.0):
        along = -along
    return middle, along


def inclinations_deg(points: NDArray, along: NDArray) -> NDArray:
    """Angles to the horizontal of the line from point to point, next to that of the direction `along` [deg]."""
    step = np.diff(points, axis=0)
    turn = np.arctan2(along[0] * step[:, 1] - along[1] * step[:, 0], step @ along)
    turn -= np.pi * np.round(turn / np.pi)  # a line has no sense
    return np.degrees(np.arctan2(along[1], along[0]) + turn)


def circle_curvature(points: NDArray) -> float:
    """Curvature of the circle through points, by least squares; positive if its centre lies above [1/m].

    Linear in the curvature, so that a straight line is a circle too; for arcs up to a half circle.
    """
    t, d = _along_and_across(points)
    (a, b, c), *_ = np.linalg.lstsq(np.column_stack([t**2 + d**2, t, np.ones_like(t)]), d, rcond=None)
    return float(2.0 * a / np.sqrt(max(1.0 + b**2 - 4.0 * a * c, 1e-12)))


def parabola_curvature(points: NDArray) -> float:
    """Curvature, at its apex, of the parabola through points whose axis is normal to their chord [1/m]."""
    t, d = _along_and_across(points)
    return float(2.0 * np.polyfit(t, d, 2)[0])


def _along_and_across(points: NDArray) -> tuple[NDArray, NDArray]:
    """Coordinates along the chord of points and across it [m]."""
    middle, along = chord(points)
    return (points - middle) @ along, (points - middle) @ [-along[1], along[0]]
