"""Cells that fit a drawn silo; where none divide both its width and its height, its top or the fill moves a little."""

import math

import numpy as np

from taichi_silo.scene import cell_sizes
from taichi_silo.scene.silo import Silo

HAIR = 2e-4  # of the height, by which its top may be moved
MOST_CELLS = 1_000_000  # of a grid for ten cells across the opening
LEAST = 1.0 / cell_sizes.ACROSS  # of the width: a body that is smaller is below a cell


def fitted(silo: Silo) -> tuple[Silo, float, str]:
    """The silo with a cell size that divides width and height, and a sentence about it.

    Ten cells or more cross the narrowest opening, unless that makes more than a million. The top is moved by a hair if
    that makes the cells divide; else the fill ends below it.
    """
    wide, high, narrow = silo.width_m, silo.height_m, cell_sizes.opening_m(silo)
    most = min(cell_sizes.MOST // 2, math.isqrt(int(MOST_CELLS * wide / high)))
    fewest = min(most, math.ceil(max(cell_sizes.wanted_across(silo), cell_sizes.TEN * wide / narrow) - 1e-9))
    sizes = cell_sizes.dividing(silo, 2 * fewest)
    sizes = sizes[wide / sizes > fewest - 0.5]
    changed = ""
    if len(sizes):
        size = cell_sizes.short(silo, float(sizes[0]))
    else:
        cells = wide / np.arange(fewest, 2 * fewest)
        over, below = high - np.round(high / cells) * cells, high - np.floor(high / cells) * cells
        near = np.flatnonzero(np.abs(over) <= HAIR * high)
        moved = len(near) > 0
        size = float(cells[int(near[0]) if moved else int(np.argmin(below))])
        filled = (round(high / size) if moved else math.floor(high / size)) * size
        silo = _up_to(silo, filled, moved)
        what = "its top was moved by" if moved else "the fill ends below the top by"
        changed = f"; {what} {1e3 * abs(high - filled):.2g} mm, to {filled:.6g} m, so that cells divide the height"
    if narrow / size < cell_sizes.TEN - 1e-6:
        changed = f", fewer than the ten that it should have{changed}"
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
