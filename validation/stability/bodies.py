"""Small bodies on a grid: what the experiments of the stability map are made of."""

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.solver import Solver


def block(*, width, height, cell, points_per_axis=1, density=1500.0, origin=(0.0, 0.0), box=None, extra=(), keep=None):
    """A rectangle of points at rest without stress, in a grid over `box` (width, height) [m].

    Parameters
    ----------
    width, height, cell : size, cells [m].
    points_per_axis : points along the edge of a cell.
    density : [kg/m3].
    origin : of the rectangle's lower left corner.
    extra : names of further fields (see `Particles`).
    keep : function of the places (points, 2), relative to the origin, that says which points there are; all if None.

    Returns
    -------
    particles, grid

    """
    d = cell / points_per_axis
    columns, rows = round(width / d), round(height / d)
    x, y = np.meshgrid((np.arange(columns) + 0.5) * d, (np.arange(rows) + 0.5) * d)
    place = np.stack([x.ravel(), y.ravel()], axis=1)
    place = place if keep is None else place[keep(place)]
    count = len(place)
    particles = Particles(count, tuple(extra))
    particles.load(
        {
            "position": place + np.array(origin),
            "velocity": np.zeros((count, 2)),
            "stress": np.zeros((count, 4)),
            "mass": np.full(count, density * d * d),
            "volume": np.full(count, d * d),
            "path": np.zeros(count),
            "domain": np.tile([d, 0.0, 0.0, d], (count, 1)),
            "intergranular": np.zeros((count, 4)),
        }
    )
    return particles, Grid(*(box or (width, height)), cell, copies=runtime.threads())


def change(particles, **fields):
    """Replace fields by arrays."""
    particles.load(particles.arrays() | fields)


def solver(particles, grid, shape, law, walls=(), **options):
    """The solver without noise control unless one is given."""
    return Solver(particles, grid, shape, law, walls, options.pop("control", NoiseControl()), **options)
