"""A straight shear band across a specimen: thickness and inclination, with their spread.

The band is found where the shear strain is: of all straight lines the one with the most of it in a narrow strip. The
strain is then sampled along normals of that line ("stations", away from both faces); in each station the band's middle
is the centroid of the strain above half of its greatest value, and its thickness the width of that part. The
inclination is that of a line through the middles; spreads are quartiles over the stations, and for the inclination the
standard error of the fit over independent stations.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from taichi_silo.analysis.measure.raster import inverse_distance_mean, within
from taichi_silo.analysis.measure.zone import Spread

STATIONS = 41
ENDS = 0.15  # share of the band's length that is left out at either face
STRONGEST_FROM = 0.05  # greatest shear strain in excess of the surroundings, below which there is no band
CONTRAST = 3.0  # of the strain in the band over that of the surroundings, below which there is none


@dataclass(frozen=True)
class Band:
    """The strongest straight band of a specimen.

    Attributes
    ----------
    found : whether there is a band; all else is nan if not.
    thickness_m : width where the strain exceeds half of its greatest value.
    loose_thickness_m : width where the void ratio is at least `loose_from`.
    inclination_deg, inclination_error_deg : to the horizontal, and standard error of the fit.
    strain : greatest shear strain in the stations.
    stations, middles : (n, 2) places on the line and of the band's middle [m].

    """

    found: bool
    thickness_m: Spread
    loose_thickness_m: Spread
    inclination_deg: float
    inclination_error_deg: float
    strain: Spread
    stations: np.ndarray
    middles: np.ndarray


def shear_band(position, shear_strain, void_ratio, spacing_m: float, loose_from: float = 0.70) -> Band:
    """Measure the strongest straight band.

    Parameters
    ----------
    position : (n, 2) places of the points now [m].
    shear_strain : (n,) path length of the strain, or any measure of it.
    void_ratio : (n,) now.
    spacing_m : of the points at the start.
    loose_from : void ratio from which sand counts as dilated (the paper takes 0.70).

    """
    position, strain = np.asarray(position, float), np.asarray(shear_strain, float)
    nothing = Spread(np.nan, np.nan, np.nan)
    none = Band(False, nothing, nothing, np.nan, np.nan, nothing, np.empty((0, 2)), np.empty((0, 2)))
    surroundings = float(np.median(strain))
    excess = np.maximum(strain - surroundings, 0.0)
    strongest = float(np.quantile(excess, 0.98))
    if strongest < STRONGEST_FROM or strongest + surroundings < CONTRAST * surroundings:
        return none
    middle, along = _strongest_line(position, excess, spacing_m)
    across = np.array([-along[1], along[0]])
    place = (position - middle) @ along
    near = np.abs((position - middle) @ across) < 3.0 * spacing_m
    low, high = place[near].min(), place[near].max()
    cut = ENDS * (high - low)
    line = middle + np.linspace(low + cut, high - cut, STATIONS)[:, None] * along
    reach = 0.35 * (high - low)
    step = 0.1 * spacing_m
    offset = np.arange(-reach, reach + step, step)
    places = line[:, None, :] + offset[None, :, None] * across
    tree = cKDTree(position)
    inside = within(tree, places, spacing_m)
    profile = np.where(inside, inverse_distance_mean(tree, excess, places, 6), 0.0)
    density = np.where(inside, inverse_distance_mean(tree, void_ratio, places, 6), 0.0)
    middles, width, loose, peak = [], [], [], []
    for k in range(STATIONS):
        top = int(np.argmax(profile[k]))
        if not profile[k, top] > 0.0:  # no strain here: the station says nothing
            continue
        left, right = _part(profile[k] >= 0.5 * profile[k, top], top)
        weights = profile[k, left : right + 1]
        middles.append(line[k] + across * np.average(offset[left : right + 1], weights=weights))
        width.append((right - left + 1) * step)
        dense_top = left + int(np.argmax(density[k, left : right + 1]))
        some = density[k, dense_top] >= loose_from
        first, last = _part(density[k] >= loose_from, dense_top)
        loose.append((last - first + 1) * step if some else 0.0)
        peak.append(profile[k, top])
    if len(middles) < STATIONS // 2:
        return none
    middles = np.array(middles)
    angle, error = _inclination(middles, along, across, high - low - 2.0 * cut, spacing_m)
    return Band(True, Spread.of(width), Spread.of(loose), angle, error, Spread.of(peak), line, middles)


def _strongest_line(position, excess, spacing):
    """Point on, and direction of, the line with the most strain in a strip of two spacings to each side."""
    centre = position.mean(axis=0)
    best = (-1.0, None, None)
    for degrees in np.arange(30.0, 150.5, 1.0):
        along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        if degrees == 90.0:
            continue
        distance = (position - centre) @ np.array([-along[1], along[0]])
        bins = np.round(distance / spacing).astype(int)
        sums = np.bincount(bins - bins.min(), excess)
        strip = np.convolve(sums, np.ones(5), mode="same")
        # a short line through a corner must not win by density, nor a long one by length: strain per sqrt(length)
        counts = np.convolve(np.bincount(bins - bins.min()), np.ones(5), mode="same")
        score = strip / np.sqrt(np.maximum(counts, 1.0) + 5.0 * len(position) ** 0.5)
        k = int(np.argmax(score))
        if score[k] > best[0]:
            offset = (k + bins.min()) * spacing
            best = (score[k], centre + offset * np.array([-along[1], along[0]]), along)
    return best[1], best[2]


def _part(mask, k: int) -> tuple[int, int]:
    """First and last index of the run of true values around k."""
    left = right = k
    while left > 0 and mask[left - 1]:
        left -= 1
    while right < len(mask) - 1 and mask[right + 1]:
        right += 1
    return left, right


def _inclination(middles, along, across, length, spacing) -> tuple[float, float]:
    """Angle to the horizontal [deg] of the line through the middles, and its standard error."""
    t, d = middles @ along, middles @ across
    slope, start = np.polyfit(t, d, 1)
    rest = d - slope * t - start
    independent = max(3.0, min(len(t), length / (3.0 * spacing)))  # stations closer than three points say the same
    error = np.sqrt(np.sum(rest**2) / len(t) / independent) / max(np.std(t), 1e-12)
    direction = along + slope * across
    angle = np.degrees(np.arctan2(abs(direction[1]), abs(direction[0])))
    return float(angle), float(np.degrees(np.arctan(error)))
