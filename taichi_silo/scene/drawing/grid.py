"""Cells that fit a drawn silo."""

import math

from taichi_silo.scene import cell_sizes
from taichi_silo.scene.silo import Silo

MOST_CELLS = 1_000_000  # of a grid for ten cells across the opening
LEAST = 1.0 / cell_sizes.ACROSS  # of the width: a body that is smaller is below a cell


def fitted(silo: Silo) -> tuple[float, str]:
    """A cell size that fits the silo [m], and a sentence about it.

    Ten cells or more cross the narrowest opening, unless that makes more than a million.
    """
    wide, high, narrow = silo.width_m, silo.height_m, cell_sizes.opening_m(silo)
    most = min(cell_sizes.MOST // 2, math.isqrt(int(MOST_CELLS * wide / high)))
    fewest = min(most, math.ceil(max(cell_sizes.wanted_across(silo), cell_sizes.TEN * wide / narrow) - 1e-9))
    size = cell_sizes.short(silo, cell_sizes.coarsest(silo, fewest, 2 * fewest) or wide / fewest)
    few = ", fewer than the ten that it should have" if narrow / size < cell_sizes.TEN - 1e-6 else ""
    words = (
        f"Cells of {1e3 * size:.6g} mm: {round(wide / size)} across, {narrow / size:.3g} across the narrowest opening "
        f"of {narrow:.6g} m, {silo.points(size, cell_sizes.height_m(silo, size)):,} points{few}"
    )
    return size, words
