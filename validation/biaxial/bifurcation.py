"""When, and at what angle, plane strain can localise in a band of a hypoplastic material.

Outside the band the strain rate is D, inside D + sym(g n), n the normal of the band. With T = L : D + N ||D|| the
traction rate is the same on both sides if A g = -(N n) (||D + sym(g n)|| - ||D||), A the acoustic tensor of L with the
terms of Jaumann's rate. A band whose rate grows without bound is possible first when ||sym(v n)|| = 1 for
v = -A^-1 (N n). Source: derived here; the criterion is that of W. Wu, Z. Sikora, Int. J. Eng. Sci. 29 (1991) 201-213.
"""

from collections.abc import Iterator

import numpy as np

from taichi_silo.mpm.laws.stress_point import StressPoint

ANGLES = np.arange(30.0, 85.0, 0.25)  # of the band to the horizontal [deg]
PROBE = 1e-9  # strain


def operators(point: StressPoint) -> tuple[np.ndarray, np.ndarray]:
    """L as (2, 2, 2, 2) and N as (2, 2) of a point in the plane [Pa], from rates in opposite directions."""
    L, N = np.zeros((2, 2, 2, 2)), np.zeros((2, 2))
    for (i, j), strain in {
        (0, 0): (1.0, 0.0, 0.0, 0.0), (1, 1): (0.0, 1.0, 0.0, 0.0), (0, 1): (0.0, 0.0, 0.0, 0.5),
    }.items():  # fmt: skip
        forward = _plane(point.trial(PROBE * np.array(strain))[:4] - point.stress) / PROBE
        backward = _plane(point.trial(-PROBE * np.array(strain))[:4] - point.stress) / PROBE
        L[:, :, i, j] = L[:, :, j, i] = 0.5 * (forward - backward)
        if (i, j) == (1, 1):
            N = 0.5 * (forward + backward)  # a unit rate: ||D|| = 1
    return L, N


def _plane(stress) -> np.ndarray:
    return np.array([[stress[0], stress[3]], [stress[3], stress[1]]])


def band_sizes(point: StressPoint) -> np.ndarray:
    """||sym(v n)|| for each of ANGLES; a band is possible where it reaches 1."""
    L, N = operators(point)
    T = _plane(point.stress)
    sizes = []
    for angle in np.radians(ANGLES):
        n = np.array([-np.sin(angle), np.cos(angle)])
        A = np.zeros((2, 2))
        for k in range(2):
            g = np.eye(2)[k]
            strain, spin = 0.5 * (np.outer(g, n) + np.outer(n, g)), 0.5 * (np.outer(g, n) - np.outer(n, g))
            A[:, k] = (np.einsum("ijkl,kl", L, strain) + spin @ T - T @ spin) @ n
        v = -np.linalg.solve(A, N @ n)
        sizes.append(np.linalg.norm(0.5 * (np.outer(v, n) + np.outer(n, v))))
    return np.array(sizes)


def first_bifurcation(path: Iterator[tuple[float, StressPoint]]) -> tuple[float, float] | None:
    """Strain and angle of the band [deg] at the first state of a path (strain, point) that can localise."""
    for strain, point in path:
        sizes = band_sizes(point)
        if sizes.max() >= 1.0:
            return strain, float(ANGLES[int(np.argmax(sizes))])
    return None
