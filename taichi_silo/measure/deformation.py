"""Net deformation between two states of the same points, from their positions alone."""

import numpy as np
from scipy.spatial import cKDTree

NEIGHBOURS = 9  # the point itself and its ring on a square lattice


def net_shear(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Net strain of each point other than vertical shortening: what a column that only settles does not have.

    A deformation gradient F is fitted by least squares to the nearest neighbours; the result is
    sqrt(E_xx^2 + 2 E_xy^2 + max(E_yy, 0)^2) of the Green-Lagrange strain, which neither a rotation nor an oscillation
    changes. Compaction between rigid walls, as by ratcheting, shortens the column and is not counted as shear; sand
    that is drawn into an outlet is stretched, and is.

    Parameters
    ----------
    before, after : (n, 2) positions [m].

    Returns
    -------
    (n,) norms [-].

    """
    _, index = cKDTree(before).query(before, k=min(NEIGHBOURS, len(before)))
    edges = before[index] - before[:, None]
    moved = after[index] - after[:, None]
    gram = np.einsum("nki,nkj->nij", edges, edges)
    mixed = np.einsum("nki,nkj->nij", moved, edges)
    gradient = mixed @ np.linalg.pinv(gram)
    strain = 0.5 * (np.swapaxes(gradient, 1, 2) @ gradient - np.eye(2))
    stretched = np.maximum(strain[:, 1, 1], 0.0)
    return np.sqrt(strain[:, 0, 0] ** 2 + 2.0 * strain[:, 0, 1] ** 2 + stretched**2)
