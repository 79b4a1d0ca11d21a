"""The stable time step of a lattice of points under a shape, over h / c.

With a lumped mass matrix the highest frequency obeys omega^2 <= c^2 max_p sum_i |grad S_i(x_p)|^2 / S_i(x_p)
(Irons and Treharne's argument, point by point), and the explicit step is stable up to 2 / omega. In the plane both
axes add up.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

PLACES = (np.arange(20001) + 0.5) / 20001  # of a point in its cell


def fraction(weights: ArrayLike, slopes: ArrayLike) -> float:
    """2 / sqrt(2 max sum_k S_k'^2 / S_k), from weights and derivatives of shape (nodes, places)."""
    weights, slopes = np.asarray(weights), np.asarray(slopes)
    total = np.where(weights > 0.0, slopes**2 / np.maximum(weights, 1e-300), 0.0).sum(axis=0)
    return 2.0 / math.sqrt(2.0 * float(total.max()))


def hats(x: np.ndarray, nodes: int = 4) -> np.ndarray:
    """Hat functions of the nodes -1, 0, 1, ... at x, shape (nodes, places)."""
    return np.maximum(0.0, 1.0 - np.abs(x - np.arange(-1, nodes - 1)[:, None]))
