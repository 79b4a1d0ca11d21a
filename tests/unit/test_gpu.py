"""The graphics card does the step of the processor. Skipped where there is none."""

import numpy as np
import pytest
import taichi as ti

from taichi_silo.mpm import runtime
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation

pytestmark = pytest.mark.skipif(not ti._lib.core.with_cuda(), reason="no CUDA device here")


def after(arch, steps=200, **scene):
    runtime.init(arch)
    given = {"silo": Silo(width_m=0.1, height_m=0.2), "grid": Mesh(cell_size_m=0.01)} | scene
    machine = Machine(arch=arch, threads=1)
    simulation = Simulation(Scene(flow=Flow(speed_m_per_s=0.02, displacement_m=0.002), machine=machine, **given))
    simulation.solver.advance(steps, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
    return simulation.particles.arrays(), simulation.solver.impulses.read_and_reset()[0]


@pytest.mark.parametrize(
    "scene",
    [
        {},
        {"walls": Walls(kind="smooth", friction_angle_deg=19.0)},
        {"averaging": Averaging(characteristic_length_m=0.01)},
    ],
    ids=["very rough", "smooth", "non-local"],
)
def test_both_do_the_same_step_to_round_off(scene):
    there, here = after("cuda", **scene), after("cpu", **scene)
    for name, field in here[0].items():
        assert np.abs(field - there[0][name]).max() <= 1e-9 * np.abs(field).max(), name
    assert np.abs(here[1] - there[1]).max() <= 1e-9 * np.abs(here[1]).max()
