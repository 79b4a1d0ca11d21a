"""Lines through points: inclination and curvature."""

import numpy as np


def chord(points):
    """Middle of points (n, 2), and direction of the line through them, with x >= 0 (upwards if vertical)."""
    middle = points.mean(axis=0)
    along = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    if along[0] < -1e-12 or (abs(along[0]) <= 1e-12 and along[1] < 0.0):
        along = -along
    return middle, along


def inclinations_deg(points, along):
    """Angles to the horizontal of the line from point to point, next to that of the direction `along` [deg]."""
    step = np.diff(points, axis=0)
    turn = np.arctan2(along[0] * step[:, 1] - along[1] * step[:, 0], step @ along)
    turn -= np.pi * np.round(turn / np.pi)  # a line has no sense
    return np.degrees(np.arctan2(along[1], along[0]) + turn)


def circle_curvature(points) -> float:
    """Curvature of the circle through points, by least squares; positive if its centre lies above [1/m].

    Linear in the curvature, so that a straight line is a circle too; for arcs up to a half circle.
    """
    t, d = _along_and_across(points)
    (a, b, c), *_ = np.linalg.lstsq(np.column_stack([t**2 + d**2, t, np.ones_like(t)]), d, rcond=None)
    return float(2.0 * a / np.sqrt(max(1.0 + b**2 - 4.0 * a * c, 1e-12)))


def parabola_curvature(points) -> float:
    """Curvature, at its apex, of the parabola through points whose axis is normal to their chord [1/m]."""
    t, d = _along_and_across(points)
    return float(2.0 * np.polyfit(t, d, 2)[0])


def _along_and_across(points):
    middle, along = chord(points)
    return (points - middle) @ along, (points - middle) @ [-along[1], along[0]]
