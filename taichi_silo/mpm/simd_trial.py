"""A small silo stepped on lanes and plainly: the program that proof.py runs, and whose exit code it believes."""

import sys

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.scene.scene import Machine, Mesh, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation

STEPS = 50
TOLERANCE = 1e-10  # of each field


def compare() -> str:
    """Step a small silo on lanes and plainly; empty if both agree."""
    ends = []
    for lanes in (False, True):
        runtime.init()
        scene = Scene(
            silo=Silo(width_m=0.1, height_m=0.2),
            walls=Walls(kind="smooth", friction_angle_deg=19.0), grid=Mesh(cell_size_m=0.02),
            machine=Machine(threads=1),
        )  # fmt: skip
        simulation = Simulation(scene, lanes=lanes)
        simulation.solver.advance(STEPS, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
        ends.append(simulation.particles.arrays())
    for name, field in ends[0].items():
        apart = np.abs(field - ends[1][name]).max()
        if not apart <= TOLERANCE * np.abs(field).max():
            return f"lanes and plain loop differ by {apart:g} in {name}"
    return ""


if __name__ == "__main__":
    found = compare()
    print(found)
    sys.exit(1 if found else 0)
