"""Sizes of square cells that fit a silo: they divide its width and height, and the outlet's edges lie on the grid."""

import math
from typing import TYPE_CHECKING

import numpy as np

from taichi_silo.scene import polygons

if TYPE_CHECKING:
    from taichi_silo.scene.silo import Silo

ACROSS = 40  # cells across a silo, where nobody says how many
USUAL = (20, 80)  # cells across, between which a default size stays if it fits
TEN = 10  # fewest along the height, and fewest that should cross an opening (`known_limits.py`)
RANGE = 4.0  # how many times more or fewer cells than wanted may be taken to fit
NAMED = 3  # sizes in a sentence
MOST = 2000  # cells across that are looked at
TOLERANCE = 1e-6  # of a cell: what counts as whole


def whole(length_m: float, size_m: float | np.ndarray) -> np.ndarray:
    """Whether cells of a size, or of sizes, divide a length."""
    cells = length_m / np.asarray(size_m)
    return np.abs(cells - np.round(cells)) <= TOLERANCE


def edges(silo: "Silo") -> tuple[float, ...]:
    """Places x or y that must lie on the grid: edges of outlets in floor and walls, sides of a column [m]."""
    if silo.column_m is not None:
        return silo.column_m
    return tuple(edge for one in silo.openings for edge in (one.low, one.high)) if silo.outlets else ()


def opening_m(silo: "Silo") -> float:
    """Narrowest place that sand passes, the outlet or one between the walls above it [m]."""
    left, right = silo.sides
    levels = np.unique(np.concatenate([left[:, 1], right[:, 1]]))
    levels = np.sort(np.concatenate([levels, levels + polygons.SAME]))  # below and above a ledge
    widths = polygons.place(right, levels) - polygons.place(left, levels)
    above = widths[: int(np.argmax(widths)) + 1]  # a roof over the widest place holds sand, and no more
    return min(float(above.min()), narrowest_m(silo))


def narrowest_m(silo: "Silo") -> float:
    """Width of the narrowest outlet [m]."""
    return min(one.width for one in silo.openings)


def dividing(silo: "Silo", most: float) -> np.ndarray:
    """Sizes [m], the largest first, that fit a silo, with at most so many cells across, and two or more each way."""
    wide, high = silo.width_m, silo.height_m
    counts = np.arange(2, max(2, min(MOST, math.ceil(most))) + 1)
    counts = counts[counts % 2 == 0] if silo.section == "round" else counts  # the axis is a line of the grid
    sizes = wide / counts
    fits = whole(high, sizes) & (np.round(high / sizes) >= 2) & (narrowest_m(silo) >= 2.0 * sizes * (1.0 - 1e-9))
    for edge in edges(silo):
        fits &= whole(edge, sizes)
    return sizes[fits]


def chosen(silo: "Silo", default_m: float) -> float:
    """The size [m] where none is given.

    The default, if it fits and makes 20 to 80 cells across; else the one that makes about 40, or ten rows if that is
    more; one that does not fit if none does.
    """
    across, wanted = silo.width_m / default_m, wanted_across(silo)
    near = USUAL[0] - TOLERANCE <= across <= USUAL[1] + TOLERANCE
    sizes = dividing(silo, RANGE * max(wanted, across if near else 0.0))
    if near and (np.abs(sizes / default_m - 1.0) < TOLERANCE).any():
        return default_m
    fitting = nearest(silo, wanted)
    if fitting is None:
        return default_m if near else float(f"{silo.width_m / ACROSS:.2g}")
    return fitting


def nearest(silo: "Silo", across: float) -> float | None:
    """The size [m] that fits and makes nearest to so many cells across; None if none within a factor of four fits."""
    sizes = dividing(silo, RANGE * across)
    sizes = sizes[silo.width_m / sizes >= across / RANGE]
    if not len(sizes):
        return None
    return short(silo, float(min(sizes, key=lambda size: abs(math.log(silo.width_m / size / across)))))


def wanted_across(silo: "Silo") -> float:
    """Cells across a silo that resolve it: 40, or as many as make ten rows."""
    return max(float(ACROSS), TEN * silo.width_m / silo.height_m)


def remedy(silo: "Silo", size_m: float) -> str:
    """The sizes that fit nearest to one that does not, the largest first, in words; or which silo it would fit."""
    near = sorted(dividing(silo, MOST), key=lambda size: abs(math.log(size / size_m)))[:NAMED]
    if not near:
        return _others(silo, size_m)
    words = [f"{short(silo, float(size)):.12g}" for size in sorted(near, reverse=True)]
    return f"{' or '.join(filter(None, [', '.join(words[:-1]), words[-1]]))} m would do"


def _others(silo: "Silo", size_m: float) -> str:
    """The silo nearest to one that no square cells fit, for cells of about a size, in words."""
    least = 4.0 if silo.section == "round" else 2.0
    size = float(f"{min(size_m, silo.width_m / least, silo.height_m / 2.0):.2g}")
    step = size * (2.0 if silo.section == "round" else 1.0)
    wide, high = max(1, round(silo.width_m / step)) * step, max(2, round(silo.height_m / size)) * size
    outlet = " with the outlet's edges on its grid" if edges(silo) else ""
    return (
        f"no square cells fit a width of {silo.width_m:.10g} m and a height of {silo.height_m:.10g} m, but cells of "
        f"{size:.6g} m fit a silo {wide:.6g} m wide and {high:.6g} m high{outlet}"
    )


def short(silo: "Silo", size_m: float) -> float:
    """The size with the fewest digits that still fits a silo, as one does."""
    lengths = (silo.width_m, silo.height_m, *edges(silo))
    for digits in range(2, 16):
        less = float(f"{size_m:.{digits}g}")
        if all(whole(one, less) and round(one / less) == round(one / size_m) for one in lengths):
            return less
    return size_m
