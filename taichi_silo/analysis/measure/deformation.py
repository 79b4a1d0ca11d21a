"""Net deformation between two states of the same points, from their positions alone."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

NEIGHBOURS = 9  # the point itself and its ring on a square lattice
FLAT = 1e-9  # determinant over squared trace below which neighbours stand in a line


class Rings:
    """Points (n, 2) [m] and their nearest neighbours in one state, ready to be compared with any later one."""

    def __init__(self, before: NDArray) -> None:
        _, self.index = cKDTree(before).query(before, k=min(NEIGHBOURS, len(before)))
        edges = before[self.index] - before[:, None]
        self.weights = edges @ _inverse(np.swapaxes(edges, 1, 2) @ edges)

    def net_shear(self, after: NDArray) -> NDArray:
        """Net strain (n,) of each point, vertical shortening left out: 0 in a column that only settles [-].

        `after` are the positions now, (n, 2) [m]. A deformation gradient F is fitted by least squares to the nearest
        neighbours; the result is sqrt(E_xx^2 + 2 E_xy^2 + max(E_yy, 0)^2) of the Green-Lagrange strain, which neither a
        rotation nor an oscillation changes. Compaction between rigid walls, as by ratcheting, shortens the column and
        does not count as shear; sand that is drawn into an outlet is stretched, and does.
        """
        moved = after[self.index] - after[:, None]
        gradient = np.swapaxes(moved, 1, 2) @ self.weights
        strain = 0.5 * (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(2))
        stretched = np.maximum(strain[:, 1, 1], 0.0)
        return np.sqrt(strain[:, 0, 0] ** 2 + 2.0 * strain[:, 0, 1] ** 2 + stretched**2)


def _inverse(gram: NDArray) -> NDArray:
    """Inverse of symmetric matrices (n, 2, 2); the pseudo-inverse where neighbours stand in a line."""
    a, b, d = gram[:, 0, 0], gram[:, 0, 1], gram[:, 1, 1]
    determinant = a * d - b * b
    flat = determinant <= FLAT * (a + d) ** 2
    found = np.stack([np.stack([d, -b], axis=1), np.stack([-b, a], axis=1)], axis=1)
    found /= np.where(flat, 1.0, determinant)[:, None, None]
    found[flat] = np.linalg.pinv(gram[flat])
    return found
