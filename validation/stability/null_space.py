"""Failure mode 4: patterns of stress that no node feels."""

import math

import numpy as np

from taichi_silo.mpm.filters import FILTERS
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls import Coulomb, Frictionless, PlaneWall
from validation.stability.bodies import block, change, solver
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "4 null space"
CELL, CELLS, DENSITY = 0.01, 16, 1500.0
LAW = Elastic(1e6, 0.0)
AMPLITUDE = 1e3  # [Pa]


def null_part(position, volume, stress, cell: float) -> np.ndarray:
    """Stresses (points, 4) less the plane in each cell that its hat functions can feel: what no node feels [Pa]."""
    place = position / cell
    index = np.floor(place).astype(int)
    local = place - index
    key = index[:, 0] * 10_000 + index[:, 1]
    rest = np.array(stress, dtype=float)
    for one in np.unique(key):
        here = key == one
        basis = np.column_stack([np.ones(here.sum()), local[here]])
        weight = np.sqrt(volume[here])[:, None]
        rest[here] -= basis @ np.linalg.lstsq(weight * basis, weight * stress[here], rcond=1e-6)[0]
    return rest


def closed_box(shape, per_axis: int, filtering):
    """A block of elastic sand between four smooth walls from which it does not part."""
    size = CELL * CELLS
    particles, grid = block(
        width=size, height=size, cell=CELL, points_per_axis=per_axis, density=DENSITY,
        extra=Particles.extras(LAW, shape, Flip()),
    )  # fmt: skip
    far = CELLS + MARGIN
    walls = (
        PlaneWall("left", 0, -1, MARGIN, Frictionless()), PlaneWall("right", 0, 1, far, Frictionless()),
        PlaneWall("bottom", 1, -1, MARGIN, Frictionless()), PlaneWall("top", 1, 1, far, Frictionless()),
    )  # fmt: skip
    return particles, solver(particles, grid, shape, LAW, walls, filtering=filtering)


def time_step(shape) -> float:
    """Half of the stable one [s]."""
    return 0.5 * shape.stable_fraction * CELL / math.sqrt(LAW.young_modulus_Pa / DENSITY)


def checkerboard_left(shape, per_axis: int, filtering=None, steps: int = 1000) -> float:
    """RMS of what is left of a checkerboard of stress from point to point, over its first RMS.

    Nothing resists it, and nothing removes it, but a filter.
    """
    particles, body = closed_box(shape, per_axis, filtering)
    d = CELL / per_axis
    index = np.floor(particles.arrays()["position"] / d).astype(int)
    sign = (-1.0) ** index.sum(axis=1)
    first = np.stack([sign, sign, 0.0 * sign, 0.0 * sign], axis=1) * AMPLITUDE
    change(particles, stress=first)
    before = particles.arrays()
    start = null_part(before["position"], before["volume"], before["stress"], CELL)
    body.advance(steps, time_step(shape))
    now = particles.arrays()
    after = null_part(now["position"], now["volume"], now["stress"], CELL)
    return float(np.sqrt((after**2).mean() / (start**2).mean()))


def wave_left(shape, per_axis: int, filtering=None, steps: int = 1000) -> float:
    """Share that is left of a stress at rest, sigma_yy = A cos(2 pi x / 8 h); exactly 1."""
    particles, body = closed_box(shape, per_axis, filtering)
    wave = np.cos(2.0 * math.pi * particles.arrays()["position"][:, 0] / (8.0 * CELL))
    zero = 0.0 * wave
    change(particles, stress=np.stack([zero, AMPLITUDE * wave, zero, zero], axis=1))
    body.advance(steps, time_step(shape))
    return float(particles.arrays()["stress"][:, 1] @ wave / (wave @ wave) / AMPLITUDE)


def ringing(shape, per_axis: int, filtering=None, steps: int = 20_000) -> float:
    """RMS of the null part of the stress in a column that swings under its weight, over the mean stress; inf if lost.

    It sinks by up to 40 % of its height, so its points keep crossing cells; at less than half of it it has collapsed.
    """
    height, g = 0.2, 9.81
    law = Elastic(DENSITY * g * height / 0.2, 0.0)
    particles, grid = block(
        width=2 * CELL, height=height, cell=CELL, points_per_axis=per_axis, density=DENSITY,
        box=(2 * CELL, 1.2 * height), extra=Particles.extras(law, shape, Flip()),
    )  # fmt: skip
    walls = (
        PlaneWall("left", 0, -1, MARGIN, Coulomb()), PlaneWall("right", 0, 1, MARGIN + 2, Coulomb()),
        PlaneWall("floor", 1, -1, MARGIN, Frictionless()),
    )  # fmt: skip
    body = solver(particles, grid, shape, law, walls, filtering=filtering)
    c = math.sqrt(law.young_modulus_Pa / DENSITY)
    body.advance(steps, 0.2 * CELL / c, gravity=(g, g))
    now = particles.arrays()
    stands = now["position"][:, 1].max() > 0.5 * height
    if not (stands and np.isfinite(now["stress"]).all() and (now["volume"] > 0.0).all()):
        return math.inf
    rest = null_part(now["position"], now["volume"], now["stress"], CELL)
    return float(np.sqrt((rest[:, 1] ** 2).mean()) / (0.5 * DENSITY * g * height))


def measure(full: bool = True) -> list[Measurement]:
    """Checkerboards with four and nine points, a stress at rest, and a long run, with and without filters."""
    found = []
    shapes = ("ugimp", "linear", "cpdi", "bspline", "cpgimp") if full else ("ugimp",)
    for per_axis in (2, 3) if full else (2,):
        words = f"{per_axis**2} points a cell"
        left, kept, rings = {}, {}, {}
        for name in shapes:
            for filter_name, filtering in FILTERS.items():
                if filter_name != "none" and name not in ("ugimp", "linear"):
                    continue
                shape = SHAPES[name](0.5 / per_axis)
                method = name if filter_name == "none" else f"{name} + {filter_name} filter"
                left[method] = checkerboard_left(shape, per_axis, filtering)
                kept[method] = abs(wave_left(shape, per_axis, filtering) - 1.0)
                if full:
                    rings[method] = ringing(shape, per_axis, filtering)
        found += measurements(f"checkerboard left after 1,000 steps, {words}", "of its start", "<=", 0.01, left)
        found += measurements(f"change of a stress wave at rest, {words}", "of its size", "<=", 0.05, kept)
        found += measurements(f"null part of the stress, 20,000 steps, {words}", "of the mean", "<=", 0.05, rings)
    return found
