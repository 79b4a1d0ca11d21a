"""Sizes of square cells that fit a silo: they divide its width and height, and the outlet's edges lie on the grid."""

from collections.abc import Sequence

import numpy as np

ACROSS = 40  # cells across a silo, where nobody says how many
OPENING = 10  # cells that an opening should be wide (`known_limits.py`), and fewest along the height
RANGE = 4.0  # how many times more or fewer cells may be taken to fit
TOLERANCE = 1e-6  # of a cell: what counts as whole


def whole(length_m: float, size_m: float | np.ndarray) -> np.ndarray:
    """Whether cells of a size, or of sizes, divide a length."""
    cells = length_m / np.asarray(size_m)
    return np.abs(cells - np.round(cells)) <= TOLERANCE


def dividing(
    width_m: float, height_m: float, edges_m: Sequence[float] = (), even: bool = False, most: int = 400
) -> list[float]:
    """Sizes [m], the largest first, that divide width and height into at least two cells.

    Parameters
    ----------
    width_m, height_m : of the silo.
    edges_m : places x that must lie on the grid.
    even : the axis at half the width must, too.
    most : cells across.

    """
    counts = np.arange(2, most + 1)
    counts = counts[counts % 2 == 0] if even else counts
    sizes = width_m / counts
    fits = whole(height_m, sizes) & (np.round(height_m / sizes) >= 2)
    for edge in edges_m:
        fits &= whole(edge, sizes)
    return [_short(float(size), (width_m, height_m, *edges_m)) for size in sizes[fits]]


def wanted_across(width_m: float, height_m: float, opening_m: float) -> float:
    """Cells across a silo that resolve it: 40, or as many as give the opening, and the height, ten."""
    return max(float(ACROSS), OPENING * width_m / min(opening_m, height_m))


def _short(size_m: float, lengths_m: Sequence[float]) -> float:
    """The size with the fewest digits that still divide all lengths."""
    for digits in range(2, 16):
        short = float(f"{size_m:.{digits}g}")
        if short > 0.0 and all(
            whole(length, short) and round(length / short) == round(length / size_m) for length in lengths_m
        ):
            return short
    return size_m
