"""Axial symmetry, ambient pressure, stretching and periodic grids, on bodies whose state is known exactly."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import j0, j1

from taichi_silo.mpm.laws import Elastic, GudehusBauer
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.walls import Frictionless, NoSlip, PlaneWall
from taichi_silo.simulation.specimen import Specimen

pytestmark = pytest.mark.usefixtures("afresh")

SAND = GudehusBauer()


def plates(grid, side=True, moving=(0.0, 1.0)):
    axis = (PlaneWall("axis", 0, -1, grid.node_along(0.0), Frictionless()),) if side else ()
    return (
        *axis, PlaneWall("bottom", 1, -1, grid.node_along(0.0), Frictionless()),
        PlaneWall("top", 1, 1, grid.top, Frictionless(), motion=moving),
    )  # fmt: skip


@pytest.mark.parametrize("axisymmetric", [False, True], ids=["plane", "round"])
def test_a_body_under_the_pressure_of_its_fluid_stays_at_rest(axisymmetric):
    body = Specimen(
        SAND, 0.6, width_m=0.02, height_m=0.02, cell_size_m=0.005, walls=plates, stress=(-5e4, -5e4, -5e4, 0.0),
        ambient_pressure=5e4, right_m=0.01, axisymmetric=axisymmetric, per_axis=2,
    )  # fmt: skip
    reading = body.drive(1e-3, 0.0)
    assert reading.kinetic_energy_J < 1e-25
    assert np.abs(reading.stress_Pa + [5e4, 5e4, 5e4, 0.0]).max() < 1e-7
    assert np.abs(reading.plate_force_N).max() < 1e-7


def test_without_the_fluid_it_bursts_apart():
    body = Specimen(
        SAND, 0.6, width_m=0.02, height_m=0.02, cell_size_m=0.005, walls=plates, stress=(-5e4, -5e4, -5e4, 0.0),
        right_m=0.01, per_axis=2,
    )  # fmt: skip
    body.drive(5e-4, 0.0)
    assert -body.drive(5e-4, 0.0).stress_Pa[0] < 1e3


@pytest.mark.parametrize("axisymmetric", [False, True], ids=["plane", "round"])
def test_an_elastic_body_between_plates_carries_exactly_hookes_stress(axisymmetric):
    """Free to swell sideways: E eps for a rod, E eps / (1 - nu^2) in plane strain; the plate feels it."""
    law = Elastic(1e6, 0.3)
    body = Specimen(
        law, 0.6, width_m=0.02, height_m=0.02, cell_size_m=0.005, walls=plates, stress=(0.0, 0.0, 0.0, 0.0),
        right_m=0.01, axisymmetric=axisymmetric, per_axis=2, control=NoiseControl(filling_drag=0.0, drag=200.0),
    )  # fmt: skip
    for speed in (-0.002, -0.004, -0.004, -0.004, 0.0, 0.0, 0.0):
        reading = body.drive(0.005, speed)
    strain = math.log(reading.height_m / 0.02)
    wanted = 1e6 * strain / (1.0 if axisymmetric else 1.0 - 0.09)
    assert reading.stress_Pa[1] == pytest.approx(wanted, rel=2e-3)
    assert abs(reading.stress_Pa[0]) < 2e-3 * abs(wanted)
    points = body.particles.arrays()
    radius = points["position"][:, 0].max() * 0.02 / 0.01875  # the outermost points stood 1.25 mm inside the face
    area = 0.5 * radius**2 if axisymmetric else radius
    assert reading.plate_force_N[1] == pytest.approx(wanted * area, rel=0.01)


def test_a_round_body_breathes_with_its_period():
    """Plane-strain breathing mode of an elastic cylinder: x J0(x) = (1 - 2 nu) / (1 - nu) J1(x), omega = x c / R."""
    nu, radius = 0.3, 0.04
    law = Elastic(1e7, nu)
    root = brentq(lambda x: x * j0(x) - (1 - 2 * nu) / (1 - nu) * j1(x), 1.0, 2.4)
    body = Specimen(
        law, 0.6, width_m=radius, height_m=0.004, cell_size_m=0.002, walls=plates, stress=(0.0, 0.0, 0.0, 0.0),
        right_m=0.01, axisymmetric=True, per_axis=2,
    )  # fmt: skip
    state = body.particles.arrays()
    state["velocity"][:, 0] = 1e-3 * j1(root * state["position"][:, 0] / radius)
    body.particles.load(state)
    density = law.grain_density / 1.6
    c = math.sqrt((law.lame + 2.0 * law.shear_modulus) / density)
    period = 2.0 * math.pi * radius / (root * c)
    energy = [body.drive(period / 200, 0.0).kinetic_energy_J for _ in range(220)]
    quiet = np.argsort(energy[20:90])[0] + 21, np.argsort(energy[120:190])[0] + 121  # quarter and three quarters
    assert (quiet[1] - quiet[0]) * period / 200 == pytest.approx(0.5 * period, rel=0.02)
    assert min(energy[20:90]) < 0.01 * energy[0]


def test_a_thick_pipe_has_lames_hoop_stress():
    """Pressed from outside only: sigma_rr = -p b^2 / (b^2 - a^2) (1 - a^2 / r^2), sigma_tt with a plus sign."""
    law, a, b = Elastic(1e7, 0.3), 0.02, 0.04
    body = Specimen(
        law, 0.6, width_m=b - a, height_m=0.004, cell_size_m=0.002, stress=(0.0, 0.0, 0.0, 0.0), left_m=a, right_m=0.01,
        walls=lambda grid: plates(grid, side=False), axisymmetric=True, per_axis=2,
        control=NoiseControl(drag=3000.0, memory_time=1e9),
    )  # fmt: skip
    state = body.particles.arrays()
    r = state["position"][:, 0]
    state["stress"][:, 0] = 1e3 * b**2 / (b**2 - a**2) * (1 - a**2 / r**2)
    state["stress"][:, 2] = 1e3 * b**2 / (b**2 - a**2) * (1 + a**2 / r**2)
    state["stress"][:, 1] = 0.3 * (state["stress"][:, 0] + state["stress"][:, 2])
    body.particles.load(state)
    body.drive(2e-5, 0.0)
    # radial equilibrium d(r s_rr)/dr = s_tt holds inside: only the outer face, whose load is missing, moves
    speed = np.abs(body.particles.arrays()["velocity"][:, 0])
    inside = (r > a + 0.004) & (r < b - 0.006)
    assert speed[inside].max() < 0.02 * speed[r > b - 0.002].max()


def test_a_grid_that_stretches_keeps_the_plate_on_its_nodes():
    body = Specimen(
        SAND, 0.6, width_m=0.02, height_m=0.02, cell_size_m=0.005, walls=plates, stress=(-5e4, -5e4, -5e4, 0.0),
        ambient_pressure=5e4, right_m=0.02, per_axis=2,
    )  # fmt: skip
    for speed in (-0.01, -0.02, -0.02):
        reading = body.drive(0.02, speed)
    assert reading.height_m == pytest.approx(0.02 + reading.travel_m, rel=1e-12)
    assert reading.travel_m == pytest.approx(-0.0008, rel=1e-12)
    points = body.particles.arrays()
    assert np.ptp(points["position"][:, 1] / reading.height_m - np.repeat((np.arange(8) + 0.5) / 8, 8)) < 2e-3


def test_a_layer_in_a_periodic_grid_shears_alike_everywhere():
    def walls(grid):
        return (
            PlaneWall("bottom", 1, -1, grid.node_along(0.0), NoSlip()),
            PlaneWall("top", 1, 1, grid.top, NoSlip(), motion=(1.0, 0.0)),
        )

    law = Elastic(1e6, 0.25)
    body = Specimen(
        law, 0.6, width_m=0.01, height_m=0.02, cell_size_m=0.005, walls=walls, stress=(0.0, 0.0, 0.0, 0.0),
        follows="nothing", periodic=True, per_axis=2,
    )  # fmt: skip
    state = body.particles.arrays()
    state["velocity"][:, 0] = 0.1 * state["position"][:, 1] / 0.02
    body.particles.load(state)
    body.speed = 0.1
    reading = body.drive(0.02, 0.1)  # gamma = 0.1, the layer's top has gone a fifth of its width
    stress = body.particles.arrays()["stress"]
    assert np.ptp(stress[:, 3]) < 1e-6 * stress[:, 3].mean()
    # Jaumann's rate in simple shear: sigma_12 = G sin gamma
    assert reading.stress_Pa[3] == pytest.approx(law.shear_modulus * math.sin(0.1), rel=1e-4)
    mean = (1.0 - math.cos(0.1)) / 0.1  # of sin gamma over the interval
    assert reading.plate_force_N[0] == pytest.approx(0.01 * law.shear_modulus * mean, rel=0.005)
