"""One shear zone, measured in stations along the middle of its ridge line; the definitions are in zones.py."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from taichi_silo.analysis.measure.arcs import chord, circle_curvature, inclinations_deg, parabola_curvature
from taichi_silo.analysis.measure.band import Spread
from taichi_silo.analysis.measure.raster import sample, within
from taichi_silo.analysis.measure.shear_zones import SMALLEST_CHANGE

CELLS = 2  # of the raster a spacing
ARRIVES = 3.0  # spacings, or a thickness: how far before the strip along a wall a zone that reaches it may end
REACH = 0.3  # of the width: how far the edges of a zone are sought
FINEST = 0.1  # spacings between the places of a profile


@dataclass(frozen=True)
class Zone:
    """One zone.

    Attributes
    ----------
    component : number of the connected ridge line it belongs to.
    length_m : along its middle.
    thickness_m : t_s, width at half the greatest excess, over the stations; `half_width_m` is half its median.
    thickness_over_d50, thickness_over_internal_length : its median over the mean grain diameter and over l_c; nan if
        these are not given.
    strain : greatest excess, over the stations.
    inclination_deg : to the horizontal, rising to the right positive; the median is in (-90, 90].
    curvature_1_per_m : of the circle through the middles; positive if its centre lies above, negative for an arch.
    apex_curvature_1_per_m : of the parabola along the chord, at its apex.
    void_ratio_change : mean over the zone in excess of the body's median; nan if not given.
    kind : "dilatant", "contractant", "neutral" (smaller than 0.01), or "unknown".
    wall_left_m, wall_right_m : heights at which it meets the walls; nan if it does not.
    middle_m : (k, 2) middles.

    """

    component: int
    length_m: float
    thickness_m: Spread
    thickness_over_d50: float
    thickness_over_internal_length: float
    strain: Spread
    inclination_deg: Spread
    curvature_1_per_m: float
    apex_curvature_1_per_m: float
    void_ratio_change: float
    kind: str
    wall_left_m: float
    wall_right_m: float
    middle_m: np.ndarray

    @property
    def half_width_m(self) -> float:
        """Half-width at half maximum [m]."""
        return 0.5 * self.thickness_m.median


@dataclass(frozen=True)
class Body:
    """What all zones are measured on."""

    points: np.ndarray
    excess: np.ndarray
    change: np.ndarray | None
    spacing: float
    width: float
    clear: float


def measured_zone(body: Body, arm, component, free, junctions, d50_m, internal_length_m) -> Zone | None:
    """Measure an arm of a ridge line.

    Parameters
    ----------
    body : the points.
    arm : (k, 2) places along it [m].
    component : number of its ridge line.
    free : whether its first and its last place are free ends, not branching points.
    junctions : (m, 2) branching points [m].
    d50_m, internal_length_m : lengths that the thickness is divided by.

    Returns
    -------
    The zone; None if there are fewer than four stations or none in which the strain falls to half.

    """
    line, across = _stations(arm, body.spacing)
    offset = np.arange(-REACH, REACH, FINEST * body.spacing / body.width) * body.width
    offset -= offset[np.argmin(np.abs(offset))]
    places = line[:, None, :] + offset[None, :, None] * across[:, None, :]
    inside = within(body.points, places, body.spacing) & (places[..., 0] >= 0.0) & (places[..., 0] <= body.width)
    profile = np.where(inside, sample(body.points, body.excess, places, body.spacing), -np.inf)
    middle, thick, peak, parts = [], [], [], []
    near = np.flatnonzero(np.abs(offset) <= 1.5 * body.spacing)
    for values in profile:
        top = int(near[np.argmax(values[near])])
        sides = [_side(values[top::way], np.abs(offset[top::way] - offset[top])) for way in (-1, 1)]
        known = [side for side in sides if np.isfinite(side)]
        part = np.abs(offset - offset[top]) <= (min(known) if known else body.spacing)
        part &= np.isfinite(values)
        weight = np.maximum(values[part] - 0.5 * values[top], 0.0)
        middle.append(np.average(offset[part], weights=weight) if weight.sum() > 0.0 else offset[top])
        thick.append(2.0 * np.mean(known) if known else np.nan)
        peak.append(values[top])
        parts.append(part)
    middle = line + np.array(middle)[:, None] * across
    thick, peak = np.array(thick), np.array(peak)
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
    angle = Spread.of(angle - 180.0 * np.ceil((np.median(angle) - 90.0) / 180.0))
    change, kind = np.nan, "unknown"
    if body.change is not None:
        values = sample(body.points, body.change, places, body.spacing)[clear]
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
        inclination_deg=angle,
        curvature_1_per_m=circle_curvature(middle),
        apex_curvature_1_per_m=parabola_curvature(middle),
        void_ratio_change=change,
        kind=kind,
        wall_left_m=left,
        wall_right_m=right,
        middle_m=middle,
    )


def _stations(arm, spacing):
    """Places at every spacing along an arm, and the normals there."""
    smooth = uniform_filter1d(arm.astype(float), 4 * CELLS + 1, axis=0, mode="nearest")
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(smooth, axis=0).T))])
    length, first = np.unique(length, return_index=True)
    count = max(2, round(length[-1] / spacing) + 1)
    line = np.column_stack([np.interp(np.linspace(0.0, length[-1], count), length, smooth[first, k]) for k in (0, 1)])
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-300)[:, None]
    return line, np.column_stack([-along[:, 1], along[:, 0]])


def _side(values, distance) -> float:
    """Distance at which a profile has fallen to half of its first value; nan if there is none, or it rises before."""
    half = 0.5 * values[0]
    below = np.flatnonzero(values < half)
    if not len(below) or below[0] == 0 or values[: below[0]].max() > 1.1 * values[0]:
        return np.nan
    after, before = below[0], below[0] - 1
    if not np.isfinite(values[after]):  # the wall or the surface
        return float(distance[before])
    share = (values[before] - half) / (values[before] - values[after])
    return float(distance[before] + share * (distance[after] - distance[before]))


def _meets_walls(body, middle, free, thickness_m) -> tuple[float, float]:
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
