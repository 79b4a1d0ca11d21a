"""Cells that fit a drawn silo; where none divide both its width and its height, the fill ends a little lower."""

import math

import numpy as np

from taichi_silo.scene import cell_sizes, polygons
from taichi_silo.scene.silo import Silo

HAIR = 2e-4  # of the height, by which its top may be moved
LEAST = 1.0 / cell_sizes.ACROSS  # of the width: a body that is smaller is below a cell


def opening_m(silo: Silo) -> float:
    """Narrowest place that sand passes, the outlet or one between the walls above it [m]."""
    left, right = silo.sides
    levels = np.unique(np.concatenate([left[:, 1], right[:, 1]]))
    levels = np.sort(np.concatenate([levels, levels + polygons.SAME]))  # below and above a ledge
    widths = polygons.place(right, levels) - polygons.place(left, levels)
    return float(widths[: int(np.argmax(widths)) + 1].min())  # a roof above the widest place holds sand, and no more


def fitted(silo: Silo) -> tuple[Silo, float, str]:
    """The silo with a cell size that divides width and height, and a sentence about it.

    Its top is moved by a hair if that makes them divide; else the fill ends below it.
    """
    wide, high, narrow = silo.width_m, silo.height_m, opening_m(silo)
    fewest = math.ceil(cell_sizes.wanted_across(wide, high, narrow) - 1e-9)
    sizes = [size for size in cell_sizes.dividing(wide, high, most=2 * fewest) if wide / size > fewest - 0.5]
    changed = ""
    if sizes:
        size = sizes[0]
    else:
        counts = np.arange(fewest, 2 * fewest)
        over = high - np.round(high / (wide / counts)) * (wide / counts)
        below = high - np.floor(high / (wide / counts)) * (wide / counts)
        near = np.flatnonzero(np.abs(over) <= HAIR * high)
        number = int(near[0]) if len(near) else int(np.argmin(below))
        size = float(wide / counts[number])
        filled = round(high / size) * size if len(near) else math.floor(high / size) * size
        silo = _up_to(silo, filled, moved=bool(len(near)))
        what = "its top was moved by" if len(near) else "the fill ends below the top by"
        changed = f"; {what} {1e3 * abs(high - filled):.2g} mm, to {filled:.6g} m, so that cells divide the height"
    words = (
        f"Cells of {1e3 * size:.6g} mm: {round(wide / size)} across, {narrow / size:.3g} across the narrowest opening "
        f"of {narrow:.6g} m, {silo.points(size):,} points{changed}"
    )
    return silo, size, words


def _up_to(silo: Silo, height_m: float, moved: bool) -> Silo:
    """The silo filled to a height, its top moved there if wanted."""
    outline = silo.outline_m or ()
    if moved:
        outline = tuple((x, height_m if y == silo.height_m else y) for x, y in outline)
    return Silo.polygon(outline, height_m=height_m, inserts=silo.inserts)
