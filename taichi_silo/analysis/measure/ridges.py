"""Ridge lines of a field on a raster: thin lines, their arms and junctions.

A cell is on a ridge where the field, smoothed by a bell, curves down most across and its crest line passes through the
cell (Steger 1998). Gaps of up to a few cells, as they are left where ridges meet, are closed, lines are thinned to one
cell (Guo and Hall 1989), and stubs are cut off.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, convolve, gaussian_filter, label

AROUND = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))  # clockwise from above
RING = np.ones((3, 3), np.int8)
TRUNCATED = 4.0  # standard deviations at which the bell ends
AT_ONCE = 1 << 15  # cells whose curvature is found at once


@dataclass(frozen=True)
class Ridges:
    """Thin lines of cells (row, column)."""

    arms: list[NDArray]  # cells (k, 2) of each arm in order, without the junctions
    component: list[int]  # number of the connected line that each arm belongs to
    count: int  # of connected lines
    junctions: NDArray  # (m, 2) places where three arms or more meet
    ends: list[tuple[bool, bool]]  # of each arm, whether its first and its last cell are free (not at a junction)


def crest(field: NDArray, sigma: float) -> tuple[NDArray, NDArray, NDArray]:
    """Smooth a field by a bell of `sigma` cells and find its crest lines.

    Returns the smoothed field, whether a crest line passes through a cell, and the curvature across it [1 / cells^2].
    """
    smooth = gaussian_filter(field, sigma, mode="nearest", truncate=TRUNCATED)
    on, curvature = np.empty(field.shape, bool), np.empty(field.shape)
    reach = int(TRUNCATED * sigma + 0.5)  # of the bell, in rows
    at_once = max(reach, AT_ONCE // field.shape[1], 1)
    for first in range(0, len(field), at_once):
        rows, low = slice(first, first + at_once), max(0, first - reach)
        strip = field[low : first + at_once + reach]
        on[rows], curvature[rows] = _crest(strip, sigma, slice(first - low, first - low + at_once))
    return smooth, on, curvature


def _crest(field: NDArray, sigma: float, rows: slice) -> tuple[NDArray, NDArray]:
    """Whether a crest line passes through the cells of some rows, and the curvature across it."""

    def slope(*order: int) -> NDArray:
        return gaussian_filter(field, sigma, order=order, mode="nearest", truncate=TRUNCATED)[rows].copy()

    gradient = np.stack([slope(1, 0), slope(0, 1)], axis=-1)
    mixed = slope(1, 1)
    hessian = np.stack([slope(2, 0), mixed, mixed, slope(0, 2)], axis=-1).reshape(*mixed.shape, 2, 2)
    value, vector = np.linalg.eigh(hessian)
    across, curvature = vector[..., 0], value[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = -np.sum(gradient * across, axis=-1) / curvature
        place = np.nan_to_num(shift[..., None] * across, nan=9.0, posinf=9.0, neginf=9.0)
    # 0.6 instead of half a cell: a crest on the boundary of two cells belongs to both
    # on a flank the field curves up across and, if the ridge is bent, down along it: that is no crest
    on = (curvature < 0.0) & (value[..., 1] < -curvature) & (np.abs(place).max(axis=-1) <= 0.6)
    return on, curvature


def thin(mask: NDArray) -> NDArray:
    """Thin a mask (rows, columns) to lines of one cell."""
    mask = np.pad(np.asarray(mask, bool), 1)
    while True:
        before = mask.sum()
        for turn in (0, 4):
            ring = [np.roll(mask, (-dr, -dc), (0, 1)) for dr, dc in AROUND]
            pairs = [[ring[(k + shift) % 8] | ring[(k + 1 + shift) % 8] for k in (0, 2, 4, 6)] for shift in (0, 1)]
            parts = sum((~ring[k] & pairs[1][k // 2]).astype(np.int8) for k in (0, 2, 4, 6))
            count = np.minimum(np.sum(pairs[0], axis=0, dtype=np.int8), np.sum(pairs[1], axis=0, dtype=np.int8))
            a, b, c, d = (ring[(k + turn) % 8] for k in (4, 5, 7, 6))
            mask = mask & ~((parts == 1) & (count >= 2) & (count <= 3) & ~((a | b | ~c) & d))
        if mask.sum() == before:
            return mask[1:-1, 1:-1]


def ridges(mask: NDArray, close: int, shortest: int, width: NDArray, keep: NDArray) -> Ridges:
    """Find the thin lines of a mask of crest cells.

    Parameters
    ----------
    mask : (rows, columns) crest cells.
    close : cells by which crests are thickened before they are thinned; gaps of twice as many are closed.
    shortest : cells; a line, or an arm with a free end, that is shorter is cut off.
    width : (rows, columns) width of the ridge in cells; an arm with a free end must be longer than it is wide.
    keep : (rows, columns) where an arm may end that is wider than long, as at a wall.

    """
    disc = np.hypot(*np.mgrid[-close : close + 1, -close : close + 1]) <= close + 0.3
    lines = thin(binary_dilation(np.pad(mask, close), disc))[close:-close, close:-close] if close else thin(mask)
    while True:
        found = _graph(lines, shortest)
        cut = []
        for k, (arm, ends) in enumerate(zip(found.arms, found.ends, strict=True)):
            tips = [arm[0]] * ends[0] + [arm[-1]] * ends[1]
            least = shortest
            if not (sum(ends) == 1 and keep[tuple(tips[0])]):
                least = max(shortest, np.median(width[tuple(arm.T)]))
            if tips and len(arm) < least + close * sum(ends):  # thickening has made free ends longer
                cut.append((len(arm), k))
        if not cut:
            return found
        lines = lines.copy()
        lines[tuple(found.arms[min(cut)[1]].T)] = False  # the shortest first: its neighbours may become one arm
        lines = thin(lines)


def _graph(lines: NDArray, shortest: int) -> Ridges:
    """Arms and junctions of thin lines; junctions with a short arm between them are one."""
    crowd = lines & (convolve(lines.astype(np.int8), RING, mode="constant") - 1 >= 3)
    whole, count = label(lines, RING)
    while True:
        knots, knot_count = label(crowd, RING)
        pieces, piece_count = label(lines & ~crowd, RING)
        meets = [np.setdiff1d(pieces[binary_dilation(knots == k, RING)], [0]) for k in range(1, knot_count + 1)]
        bends = [k + 1 for k, around in enumerate(meets) if len(around) < 3]
        if bends:
            crowd = crowd & ~np.isin(knots, bends)
            continue
        sizes = np.bincount(pieces[pieces > 0], minlength=piece_count + 1)
        between = [
            p for p in range(1, piece_count + 1) if sizes[p] < shortest and sum(p in around for around in meets) == 2
        ]
        if not between:
            break
        crowd = crowd | (pieces == between[0])
    arms, component, ends = [], [], []
    for piece in range(1, piece_count + 1):
        arm = _ordered(np.argwhere(pieces == piece))
        arms.append(arm)
        component.append(int(whole[tuple(arm[0])]) - 1)
        first, last = (not knots[max(r - 1, 0) : r + 2, max(c - 1, 0) : c + 2].any() for r, c in (arm[0], arm[-1]))
        # a stub of a cell or two touches its junction with both ends
        ends.append((False, True) if len(arm) < shortest and not (first or last) else (first, last))
    junctions = [np.argwhere(knots == k).mean(axis=0) for k in range(1, knot_count + 1)]
    return Ridges(arms, component, count, np.array(junctions).reshape(-1, 2), ends)


def _ordered(cells: NDArray) -> NDArray:
    """Cells (k, 2) of a line in order, from one end to the other."""
    near = np.abs(cells[:, None] - cells[None]).max(axis=-1) == 1
    k = int(np.argmin(near.sum(axis=0)))  # an end has one neighbour
    order, left = [k], np.ones(len(cells), bool)
    left[k] = False
    while left.any():
        rest = np.flatnonzero(left)
        k = int(rest[np.argmin(np.abs(cells[rest] - cells[order[-1]]).sum(axis=1))])
        order.append(k)
        left[k] = False
    return cells[order]
