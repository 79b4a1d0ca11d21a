"""Net deformation between two states of the same points, from their positions alone."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

NEIGHBOURS = 9  # the point itself and its ring on a square lattice
AT_ONCE = 1 << 14  # points
FLAT = 1e-9  # determinant over squared trace below which neighbours stand in a line


class Rings:
    """Points (n, 2) [m] and their nearest neighbours in one state, ready to be compared with any later one.

    `index` (n, 9) are the numbers of the neighbours; they are sought if it is not given.
    """

    def __init__(self, before: NDArray, index: NDArray | None = None) -> None:
        self.before = before
        self.index = self._sought(before) if index is None else index

    @staticmethod
    def _sought(before: NDArray) -> NDArray:
        tree, count = cKDTree(before), min(NEIGHBOURS, len(before))
        index = np.empty((len(before), count), np.int32)
        for rows in _parts(len(before)):
            index[rows] = tree.query(before[rows], k=count)[1].reshape(-1, count)
        return index

    def net_shear(self, after: NDArray) -> NDArray:
        """Net strain (n,) of each point, vertical shortening left out: 0 in a column that only settles [-].

        `after` are the positions now, (n, 2) [m]. A deformation gradient F is fitted by least squares to the nearest
        neighbours; the result is sqrt(E_xx^2 + 2 E_xy^2 + max(E_yy, 0)^2) of the Green-Lagrange strain, which neither a
        rotation nor an oscillation changes. Compaction between rigid walls, as by ratcheting, shortens the column and
        does not count as shear; sand that is drawn into an outlet is stretched, and does.
        """
        found = np.empty(len(after))
        for rows in _parts(len(after)):
            edges, moved = (place[self.index[rows]] - place[rows, None] for place in (self.before, after))
            gradient = np.swapaxes(moved, 1, 2) @ (edges @ _inverse(np.swapaxes(edges, 1, 2) @ edges))
            strain = 0.5 * (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(2))
            stretched = np.maximum(strain[:, 1, 1], 0.0)
            found[rows] = np.sqrt(strain[:, 0, 0] ** 2 + 2.0 * strain[:, 0, 1] ** 2 + stretched**2)
        return found


def _parts(count: int) -> Iterator[slice]:
    """So many points, some at a time: their rings take ten times the room of their places."""
    return (slice(first, first + AT_ONCE) for first in range(0, count, AT_ONCE))


def _inverse(gram: NDArray) -> NDArray:
    """Inverse of symmetric matrices (n, 2, 2); the pseudo-inverse where neighbours stand in a line."""
    a, b, d = gram[:, 0, 0], gram[:, 0, 1], gram[:, 1, 1]
    determinant = a * d - b * b
    flat = determinant <= FLAT * (a + d) ** 2
    found = np.stack([np.stack([d, -b], axis=1), np.stack([-b, a], axis=1)], axis=1)
    found /= np.where(flat, 1.0, determinant)[:, None, None]
    found[flat] = np.linalg.pinv(gram[flat])
    return found
