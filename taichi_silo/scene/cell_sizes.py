"""Sizes of cells that fit a silo: they divide its width, and the edges of outlets lie on the grid.

The height need not be whole cells as long as they are wide: they are a little lower or higher then (`height_m`).
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from taichi_silo.scene import polygons

if TYPE_CHECKING:
    from taichi_silo.scene.silo import Silo

ACROSS = 40  # cells across a silo, where nobody says how many
USUAL = (20, 80)  # cells across, between which a default size stays if it fits
TEN = 10  # fewest along the height, and fewest that should cross an opening (`known_limits.py`)
WIDE_OUTLET = 16  # cells, from which on one point in each does: the grid's dead edge is a tenth of the width then
RANGE = 4.0  # how many times more or fewer cells than wanted may be taken to fit
NAMED, DIGITS = 3, 4  # sizes in a sentence, and the digits that it takes readily
FOR_SQUARES = 1.5  # times more or fewer cells are taken for square ones
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


def widest_m(silo: "Silo") -> float:
    """Width of the widest outlet [m]."""
    return max(one.width for one in silo.openings)


def narrow_outlet(silo: "Silo", cell_m: float) -> bool:
    """Whether the narrowest outlet is so few cells wide that with one point in each far too little sand falls out."""
    return narrowest_m(silo) < WIDE_OUTLET * cell_m * (1.0 - 1e-9)


def dividing(silo: "Silo", most: float, met: bool = True) -> np.ndarray:
    """Sizes [m], the largest first, that fit a silo, with at most so many cells across, and two or more each way.

    `met`: whether edges must lie on the grid.
    """
    counts = np.arange(2, max(2, min(MOST, math.ceil(most))) + 1)
    counts = counts[counts % 2 == 0] if silo.section == "round" else counts  # the axis is a line of the grid
    sizes = silo.width_m / counts
    fits = (np.round(silo.height_m / sizes) >= 2) & (narrowest_m(silo) >= 2.0 * sizes * (1.0 - 1e-9))
    for edge in edges(silo) if met else ():
        fits &= whole(edge, sizes)
    return sizes[fits & (whole(silo.height_m, sizes) | (not square(silo)))]


def square(silo: "Silo") -> bool:
    """Whether cells must be square: an outlet in a side wall has its edges on the grid, too."""
    return any(not one.in_floor for one in silo.openings)


def height_m(silo: "Silo", size_m: float) -> float:
    """Height of cells of a size [m]: that of the silo over as many rows as squares would make, to the nearest."""
    return size_m if whole(silo.height_m, size_m) else silo.height_m / max(1, round(silo.height_m / size_m))


def squares(silo: "Silo", sizes: np.ndarray) -> np.ndarray:
    """Of some sizes those that divide the height as well, which makes square cells; all of them if none does."""
    found = sizes[whole(silo.height_m, sizes)]
    return found if len(found) else sizes


def coarsest(silo: "Silo", across: float, most: float) -> float | None:
    """The largest size [m] with at least so many cells across, if one has; with more for squares."""
    sizes = dividing(silo, most)
    sizes = sizes[silo.width_m / sizes >= across * (1.0 - 1e-9)]
    return float(squares(silo, sizes[sizes > sizes[0] / FOR_SQUARES])[0]) if len(sizes) else None


def chosen(silo: "Silo", default_m: float) -> float:
    """The size [m] where none is given.

    The default, if it fits and makes 20 to 80 cells across; else the one that makes about 40, or ten rows if that is
    more; one that does not fit if none does.
    """
    across = silo.width_m / default_m
    near = USUAL[0] - TOLERANCE <= across <= USUAL[1] + TOLERANCE
    if near and (np.abs(dividing(silo, across) / default_m - 1.0) < TOLERANCE).any():
        return default_m
    fitting = nearest(silo, wanted_across(silo))
    if fitting is None:
        return default_m if near else float(f"{silo.width_m / ACROSS:.2g}")
    return fitting


def nearest(silo: "Silo", across: float) -> float | None:
    """The size [m] that makes nearest to so many cells across; None if none within a factor of four fits."""

    def off(sizes: np.ndarray) -> np.ndarray:
        return np.abs(np.log(silo.width_m / sizes / across))

    sizes = _resolving(silo, across)
    if not len(sizes):
        return None
    close = sizes[off(sizes) <= math.log(FOR_SQUARES) + TOLERANCE]
    sizes = squares(silo, close) if len(close) else sizes
    return short(silo, float(sizes[np.argmin(off(sizes))]))


def _resolving(silo: "Silo", across: float, met: bool = True) -> np.ndarray:
    """Sizes [m] that fit a silo and make so many cells across within a factor of four; `met` as in `dividing`."""
    sizes = dividing(silo, RANGE * across, met)
    return sizes[silo.width_m / sizes >= across / RANGE * (1.0 - TOLERANCE)]


def wanted_across(silo: "Silo") -> float:
    """Cells across a silo that resolve it: 40, or as many as make ten rows."""
    return max(float(ACROSS), TEN * silo.width_m / silo.height_m)


def remedy(silo: "Silo", size_m: float) -> str:
    """The sizes that fit nearest to one that does not, the largest first, in words; or where edges would fit."""
    return f"{near} m would do" if (near := _nearest_sizes(silo, size_m)) else _others(silo, size_m)


def _nearest_sizes(silo: "Silo", size_m: float) -> str:
    """The sizes that fit nearest to one that does not, the largest first; empty if none does."""

    def awkward(size: float) -> tuple[bool, float]:
        many = len(f"{size:.12g}".replace(".", "").strip("0")) > DIGITS
        return many, abs(math.log(size / size_m))

    fitting = sorted(dividing(silo, MOST), key=lambda size: abs(math.log(size / size_m)))
    near = sorted({short(silo, float(size)) for size in fitting[: 10 * NAMED]}, key=awkward)[:NAMED]
    words = [f"{size:.12g}" for size in sorted(near, reverse=True)]
    return " or ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def unmet(silo: "Silo") -> str:
    """That no cells which resolve a silo meet its edges, and where such would, in words; empty if some do.

    Empty, too, where no such cells would fit without the edges.
    """
    across = wanted_across(silo)
    sizes = _resolving(silo, across, met=False)
    if not len(sizes) or len(_resolving(silo, across)):
        return ""
    size = float(sizes[np.argmin(np.abs(np.log(silo.width_m / sizes / across)))])
    finer = _nearest_sizes(silo, size)
    return _moved(silo, size, f" of about {size:.3g} m") + (f"; {finer} m would do, too" if finer else "")


def _others(silo: "Silo", size_m: float) -> str:
    """Where edges would have to be that cells of about a size meet, in words; or what no cells are fine enough for."""
    if not edges(silo):
        return (
            f"{MOST} cells across are not fine enough for a height of {silo.height_m:g} m or an opening of "
            f"{narrowest_m(silo):g} m"
        )
    step = 2 if silo.section == "round" else 1
    count = max(2 * step, step * round(silo.width_m / size_m / step))
    return _moved(silo, silo.width_m / count)


def _moved(silo: "Silo", size_m: float, about: str = "") -> str:
    """Where edges are, and where they would be met by cells of a size that divides the width, in words."""

    def line(edge: float) -> float:
        """The nearest one, counted from the nearer wall, so that what is symmetric stays so."""
        low = edge <= 0.5 * silo.width_m
        length = size_m * math.floor((edge if low else silo.width_m - edge) / size_m + 0.5 + TOLERANCE)
        return length if low else silo.width_m - length

    places = [line(edge) for edge in edges(silo)]
    widths = [high - low for low, high in zip(places[::2], places[1::2], strict=True)]
    are, could, wide = (", ".join(f"{one:.9g}" for one in lengths) for lengths in (edges(silo), places, widths))
    what = "column" if silo.column_m is not None else "outlet" if len(widths) == 1 else "outlets"
    return (
        f"no cells{about} have lines at {are} m, the edges of the {what}, but cells of {size_m:.9g} m have lines at "
        f"{could} m (a width of {wide} m)"
    )


def short(silo: "Silo", size_m: float) -> float:
    """The size with the fewest digits that still fits a silo, as one does."""
    lengths = [one for one in (silo.width_m, silo.height_m, *edges(silo)) if whole(one, size_m)]
    for digits in range(2, 16):
        less = float(f"{size_m:.{digits}g}")
        if all(whole(one, less) and round(one / less) == round(one / size_m) for one in lengths):
            return less
    return size_m
