"""Failure mode 2: sand that is stretched until its points lose touch (numerical fracture)."""

import math

import numpy as np

from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES, ConvectedDomain
from taichi_silo.mpm.velocity_transfer import Flip
from validation.stability.bodies import block, change, solver
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "2 stretching"
CELL, RATE, MOST_STRETCH, STEPS = 0.01, 1.0, 12.0, 44
NEEDED = {False: 6.0, True: 8.0}  # stretch to survive along an axis, along the diagonal (four points a cell)
WRONG = 0.1  # relative error of the volume that counts as fracture
FREE = Elastic(0.0, 0.0)


def stretch_at_fracture(shape, diagonal: bool = False, cells: int = 12, per_axis: int = 2) -> float:
    """Stretch at which the median volume error of the inner points passes 10 %; at most 12.

    A sheet without stiffness is pulled with the velocity k n (n x), n along an axis or along the diagonal. No force
    acts, so each point keeps its velocity, and the volume of all grows as 1 + k t exactly. A method follows as long as
    neighbouring points share nodes.
    """
    size = cells * CELL
    box = (size * (MOST_STRETCH + 1.0), size * (MOST_STRETCH + 1.0 if diagonal else 3.0))
    origin = (0.5 * (box[0] - size), 0.5 * (box[1] - size))
    particles, grid = block(
        width=size, height=size, cell=CELL, points_per_axis=per_axis, origin=origin, box=box,
        extra=Particles.extras(FREE, shape, Flip()),
    )  # fmt: skip
    n = np.array([1.0, 1.0]) / math.sqrt(2.0) if diagonal else np.array([1.0, 0.0])
    start = particles.arrays()
    arm = start["position"] - np.array(origin) - 0.5 * size
    change(particles, velocity=RATE * (arm @ n)[:, None] * n)
    inner = (np.abs(arm) < 0.25 * size).all(axis=1)
    body = solver(particles, grid, shape, FREE)
    reached = 1.0
    for number in range(1, STEPS + 1):
        time = (MOST_STRETCH - 1.0) / RATE * number / STEPS
        body.advance(50, (MOST_STRETCH - 1.0) / RATE / STEPS / 50)
        volume = particles.arrays()["volume"][inner] / start["volume"][inner]
        error = float(np.median(np.abs(volume / (1.0 + RATE * time) - 1.0)))
        if not error < WRONG:
            break
        reached = 1.0 + RATE * time
    return reached


def measure(full: bool = True) -> list[Measurement]:
    """Every shape with four points a cell, along an axis and along the diagonal; full: with one as well."""
    found = []
    shapes = dict(SHAPES.items()) | {"cpdi unguarded": lambda half: ConvectedDomain(half, guarded=False)}
    for per_axis in (2, 1) if full else (2,):
        for diagonal in (False, True):
            along = "the diagonal" if diagonal else "an axis"
            words = f"stretch at fracture along {along}, {per_axis**2} point{'s' * (per_axis > 1)} a cell"
            reached = {
                name: stretch_at_fracture(kind(0.5 / per_axis), diagonal, 12, per_axis) for name, kind in shapes.items()
            }
            found += measurements(words, "-", ">=", 0.5 * per_axis * NEEDED[diagonal], reached)
    return found
