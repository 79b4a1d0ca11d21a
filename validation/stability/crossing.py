"""Failure mode 1: points that cross cells. A column is compressed through several cells under its own weight."""

import math

import numpy as np

from taichi_silo.mpm.filters import FILTERS
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls import Coulomb, PlaneWall
from validation.stability.bodies import block, solver
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "1 cell crossing"
G, HEIGHT, WIDTH, DENSITY = 9.81, 1.0, 0.1, 1500.0
MOST_ERROR = 0.02  # of the largest stress


def column_stress_error(shape, cells: int = 20, per_axis: int = 2, sinking: float = 0.2, filtering=None):
    """RMS error of the vertical stress of a soft column at rest, and by how many cells its top sank.

    At rest sigma = -(weight above), exactly, however much the column is compressed. Expectation: hat functions, whose
    gradients jump, are wrong by tens of per cent; smoother ones by the quadrature error at the floor, some per cent or
    less.

    Parameters
    ----------
    shape : of `taichi_silo.shapes`.
    cells : over the height of the column.
    per_axis : points along the edge of a cell.
    sinking : weight over stiffness.
    filtering : of the stresses.

    Returns
    -------
    RMS error over the largest stress, cells.

    """
    cell = HEIGHT / cells
    law = Elastic(DENSITY * G * HEIGHT / sinking, 0.0)
    particles, grid = block(
        width=WIDTH, height=HEIGHT, cell=cell, points_per_axis=per_axis, density=DENSITY, box=(WIDTH, 1.1 * HEIGHT),
        extra=Particles.extras(law, shape, Flip()),
    )  # fmt: skip
    start = particles.arrays()["position"][:, 1]
    walls = (
        PlaneWall("left", 0, -1, grid.node_along(0.0), Coulomb()),
        PlaneWall("right", 0, 1, grid.node_along(WIDTH), Coulomb()),
        PlaneWall("floor", 1, -1, grid.node_along(0.0), Coulomb()),
    )
    c = math.sqrt(law.young_modulus_Pa / DENSITY)
    control = NoiseControl(filling_drag=0.5 * math.pi * c / HEIGHT)
    body = solver(particles, grid, shape, law, walls, control=control, filtering=filtering)
    for gravity in ((0.0, G), (G, G)):
        body.advance(300 * cells, 0.1 * cell / c, gravity=gravity, stage="filling")
    found = particles.arrays()
    error = found["stress"][:, 1] + DENSITY * G * (HEIGHT - start)
    sunk = start.max() - found["position"][:, 1].max()
    return float(np.sqrt((error**2).mean())) / (DENSITY * G * HEIGHT), float(sunk / cell)


def measure(full: bool = True) -> list[Measurement]:
    """Every shape with four points a cell (and one and nine), and linear shapes and uGIMP with filters."""
    found = []
    for number in (4, 1, 9) if full else (4,):
        per_axis = math.isqrt(number)
        words = f"stress error, {number} point{'s' if number > 1 else ''} a cell"
        errors = {name: column_stress_error(kind(0.5 / per_axis), 20, per_axis)[0] for name, kind in SHAPES.items()}
        found += measurements(words, "of the largest", "<=", MOST_ERROR, errors)
    for name in ("linear", "ugimp") if full else ("ugimp",):
        shape = SHAPES[name](0.25)
        errors = {
            f"{name} + {word} filter": column_stress_error(shape, filtering=FILTERS[word])[0]
            for word in ("null-space", "smoothing")
        }
        found += measurements("stress error, 4 points a cell", "of the largest", "<=", MOST_ERROR, errors)
    return found
