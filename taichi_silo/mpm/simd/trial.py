"""A block of sand stepped eight points at once and plainly: the program that `selftest` runs."""

import sys

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import UniformGimp
from taichi_silo.mpm.solver import Solver
from taichi_silo.mpm.walls import Coulomb, PlaneWall

STEPS = 50
TOLERANCE = 1e-10  # of each field


def stepped(simd: bool) -> dict[str, np.ndarray]:
    """Fields of a block between smooth walls after some steps under growing gravity on a sinking bottom."""
    runtime.init()
    law, h = GudehusBauer(), 0.02
    grid = Grid(0.1, 0.24, h)
    particles = Particles.lattice(law, 0.1, 0.2, h, void_ratio=0.6)
    left, right, floor = grid.node_along(0.0), grid.node_along(0.1), grid.node_along(0.0)
    walls = (
        PlaneWall("left", 0, -1, left, Coulomb(19.0)), PlaneWall("right", 0, 1, right, Coulomb(19.0)),
        PlaneWall("bottom", 1, -1, floor, Coulomb(), motion=(0.0, 1.0)),
    )  # fmt: skip
    control = NoiseControl(drag=20.0, relaxation=20.0)
    solver = Solver(particles, grid, UniformGimp(), law, walls, control, simd=simd)
    solver.advance(STEPS, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
    return particles.arrays()


def compare() -> str:
    """Where the two ways of stepping differ; empty if they agree."""
    plain, wide = stepped(simd=False), stepped(simd=True)
    for name, field in plain.items():
        apart = np.abs(field - wide[name]).max()
        if not apart <= TOLERANCE * np.abs(field).max():
            return f"eight points at once and the plain loop differ by {apart:g} in {name}"
    return ""


if __name__ == "__main__":
    found = compare()
    print(found)
    sys.exit(1 if found else 0)
