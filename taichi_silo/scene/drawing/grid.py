"""Cells that fit a drawn silo; where none divide both its width and its height, the fill ends a little lower."""

import math

import numpy as np

from taichi_silo.scene import cell_sizes, polygons
from taichi_silo.scene.silo import Silo

LEAST = 1.0 / cell_sizes.ACROSS  # of the width: a body that is smaller is below a cell


def opening_m(silo: Silo) -> float:
    """Narrowest place between the walls, the outlet or one above it [m]."""
    left, right = silo.sides
    levels = np.unique(np.concatenate([left[:, 1], right[:, 1]]))
    levels = np.concatenate([levels, levels + polygons.SAME])  # below and above a ledge
    return float((polygons.place(right, levels) - polygons.place(left, levels)).min())


def fitted(silo: Silo) -> tuple[Silo, float, str]:
    """The silo, its fill perhaps below the top, with a cell size that divides both, and a sentence about it."""
    wide, high, narrow = silo.width_m, silo.height_m, opening_m(silo)
    fewest = math.ceil(cell_sizes.wanted_across(wide, high, narrow) - 1e-9)
    sizes = cell_sizes.dividing(wide, high, most=2 * fewest)
    sizes = [size for size in sizes if wide / size > fewest - 0.5]
    if sizes:
        size, lower = sizes[0], ""
    else:
        counts = np.arange(fewest, 2 * fewest)
        left = high / (wide / counts) % 1.0 * (wide / counts)
        size = float(wide / counts[int(np.argmin(left))])
        filled = round(math.floor(high / size) * size, 12)
        silo = silo.model_copy(update={"height_m": filled})
        silo = Silo.model_validate(silo.model_dump(exclude_defaults=True))
        lower = (
            f"; the fill ends {1e3 * (high - filled):.3g} mm below the top, at {filled:.6g} m, so that cells divide it"
        )
    words = (
        f"Cells of {1e3 * size:.6g} mm: {round(wide / size)} across, {narrow / size:.3g} across the narrowest opening of "
        f"{narrow:.6g} m, {silo.points(size):,} points{lower}"
    )
    return silo, size, words
