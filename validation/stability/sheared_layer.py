"""Failure mode 13: patterns of stress that no node feels, grown in sand that is sheared under a non-local law.

The layer of `validation.layer` on cells as long as the characteristic length, against its one-dimensional solution.
"""

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.scene.method_options import MethodOptions
from validation.layer import layer, sheared
from validation.layer_study import CASES, reference
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "13 null modes of sheared sand"
AT_M = 2e-3


def tried(shape: str, points: int, stress_filter: str) -> tuple[float, float]:
    """Error of the shear stress over the exact one, and the least vertical stress of a point over the pressure."""
    runtime.init()
    piece = layer(*CASES["a"], 1.0, points, MethodOptions(stress_filter=stress_filter), shape)
    try:
        u, tau, _height = np.array(list(sheared(piece, AT_M))).T
    except RunFailed:
        return np.nan, np.nan
    exact = np.interp(AT_M, *reference("a"))
    least = float(-piece.particles.arrays()["stress"][:, 1].max() / CASES["a"][0])
    return abs(float(np.interp(AT_M, u, tau)) / exact - 1.0), least


def measure(full: bool = True) -> list[Measurement]:
    """Shapes with one, four and nine points a cell, without a filter and with each."""
    wanted = [("ugimp", 4, "none"), ("ugimp", 4, "patch")]
    if full:
        wanted += [("ugimp", points, name) for points in (1, 9) for name in ("none", "patch")]
        wanted += [("ugimp", 4, "null-space")]
        wanted += [(shape, 4, name) for shape in ("cpgimp", "cpdi", "bspline") for name in ("none", "patch")]
    errors, least = {}, {}
    for shape, points, name in wanted:
        method = f"{shape}, {points} points" + ("" if name == "none" else f" + {name} filter")
        errors[method], least[method] = tried(shape, points, name)
    found = measurements("error of the shear stress at u = 2 mm", "of it", "<=", 0.01, errors)
    return found + measurements("least vertical stress of a point", "of the pressure", ">=", 0.9, least)
