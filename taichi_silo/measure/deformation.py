"""Net deformation between two states of the same points, from their positions alone."""

import numpy as np
from scipy.spatial import cKDTree

NEIGHBOURS = 9  # the point itself and its ring on a square lattice


def net_shear(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Net shear strain of each point.

    A deformation gradient F is fitted by least squares to the nearest neighbours; the result is the norm of the
    deviator of the Green-Lagrange strain, which neither a rotation nor an oscillation changes.

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
    deviator = strain - 0.5 * np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(2)
    return np.sqrt((deviator**2).sum(axis=(1, 2)))
