"""Walls that do not follow the grid are as exact as those that do."""

import math

import numpy as np
import pytest

from taichi_silo.mpm.field_memory import values
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.shapes import UniformGimp
from taichi_silo.mpm.walls import Coulomb, NoSlip, PlaneWall, Surface
from validation.stability.bodies import block, change, solver

pytestmark = pytest.mark.usefixtures("afresh")

G, DENSITY = 9.81, 1500.0


def slide(angle_deg, contact, mu, cell=0.05, steps=2000):
    """Mean acceleration down an incline in the second half of 0.4 s, over g, and what the wall gave (along, normal).

    An elastic block, placed with the stress that it has when it slides.
    """
    angle, height = math.radians(angle_deg), 0.2
    down, up = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    particles, grid = block(width=0.6, height=height, cell=cell, box=(3.0, 3.0))
    place = particles.arrays()["position"]
    base, above = np.array([0.6, 2.0]), height - place[:, 1]
    normal = -DENSITY * G * math.cos(angle) * above
    shear = min(mu, math.tan(angle)) * -normal
    turn = np.stack([down, up])
    local = np.zeros((len(place), 2, 2))
    local[:, 1, 1], local[:, 0, 1], local[:, 1, 0] = normal, shear, shear
    stress = np.einsum("ai,nab,bj->nij", turn, local, turn)
    change(
        particles, position=base + place[:, :1] * down + place[:, 1:] * up,
        stress=np.stack([stress[:, 0, 0], stress[:, 1, 1], 0.0 * normal, stress[:, 0, 1]], axis=1),
    )  # fmt: skip
    incline = Surface("incline", (tuple(base - 0.5 * down), tuple(base + 2.0 * down)), contact)
    body = solver(particles, grid, UniformGimp(0.5), Elastic(2e6, 0.2), surfaces=(incline,))
    velocities = []
    for _ in range(2):
        body.impulses.read_and_reset()
        body.advance(steps, 1e-4, gravity=(G, G))
        velocities.append(particles.arrays()["velocity"].mean(axis=0))
    pushed = body.impulses.read_and_reset()[0][0].sum(axis=0)
    return (velocities[1] - velocities[0]) @ down / (steps * 1e-4) / G, pushed @ down, pushed @ up


@pytest.mark.parametrize("angle", [15.0, 45.0, 70.0])
def test_a_block_slides_freely_down_any_slope_without_friction(angle):
    """No stick at the steps of the grid."""
    acceleration, along, normal = slide(angle, Coulomb(0.0), 0.0)
    assert acceleration == pytest.approx(math.sin(math.radians(angle)), rel=1e-9)
    assert abs(along) < 1e-12 * normal


@pytest.mark.parametrize(("angle", "friction"), [(5.0, 4.0), (25.0, 20.0), (45.0, 40.0), (60.0, 19.0), (60.0, 40.0)])
def test_it_slides_with_g_sin_minus_mu_cos(angle, friction):
    """Below a friction of 1, from which on waves along the face of an elastic body feed on its sliding."""
    mu = math.tan(math.radians(friction))
    acceleration, _, _ = slide(angle, Coulomb(friction), mu)
    exact = math.sin(math.radians(angle)) - mu * math.cos(math.radians(angle))
    assert acceleration == pytest.approx(exact, rel=0.005)


@pytest.mark.parametrize(
    ("angle", "contact", "mu"), [(30.0, Coulomb(31.0), 0.601), (45.0, Coulomb(46.0), 1.036), (40.0, NoSlip(), 9.0)]
)
def test_it_stays_where_friction_suffices_or_the_wall_is_very_rough(angle, contact, mu):
    acceleration, along, normal = slide(angle, contact, mu)
    assert abs(acceleration) < 0.002
    assert -along / normal == pytest.approx(math.tan(math.radians(angle)), rel=0.02)


def trough(angle_deg, cell, along_axis=2, height=1.0, foot=0.8):
    """Forces of a nearly liquid column at rest between a vertical wall and an inclined one, over the exact ones.

    Returns
    -------
    of the inclined wall in all; at most of a fifth of its height, without the highest fifth; of the vertical wall.

    """
    angle, bulk, poisson = math.radians(angle_deg), 1e7, 0.4999
    wide = math.ceil((foot + max(height * math.tan(angle), 0.0) + 0.2) / cell) * cell
    particles, grid = block(
        width=wide, height=height, cell=cell, points_per_axis=along_axis, box=(wide, height + 4 * cell),
        keep=lambda place: place[:, 0] < foot + place[:, 1] * math.tan(angle), density=DENSITY,
    )  # fmt: skip
    state, d = particles.arrays(), cell / along_axis
    for row in np.unique(np.round(state["position"][:, 1], 9)):  # rows that fit between the walls
        here = np.flatnonzero(np.abs(state["position"][:, 1] - row) < 1e-6)
        size = (foot + row * math.tan(angle)) / len(here)
        state["position"][here, 0] = (np.arange(len(here)) + 0.5) * size
        state["volume"][here], state["mass"][here] = d * size, DENSITY * d * size
    pressure = -DENSITY * G * (height - state["position"][:, 1])
    particles.load(state | {"stress": np.stack([pressure, pressure, pressure, 0.0 * pressure], axis=1)})
    upwards = np.array([math.sin(angle), math.cos(angle)])
    top = np.array([foot, 0.0]) + (height + 2.0 * cell) / math.cos(angle) * upwards
    walls = (
        PlaneWall("left", 0, -1, grid.node_along(0.0), Coulomb()),
        PlaneWall("floor", 1, -1, grid.node_along(0.0), Coulomb()),
    )
    c = math.sqrt(bulk / DENSITY)
    body = solver(
        particles, grid, UniformGimp(0.5 / along_axis), Elastic(3.0 * bulk * (1.0 - 2.0 * poisson), poisson), walls,
        control=NoiseControl(filling_drag=0.5 * math.pi * c / height, relaxation=20.0),
        surfaces=(Surface("inclined", ((foot, 0.0), tuple(top)), Coulomb()),),
    )  # fmt: skip
    dt = 0.2 * cell / c
    body.advance(6000, dt, gravity=(G, G), stage="filling")
    body.impulses.read_and_reset()
    body.advance(2000, dt, gravity=(G, G), stage="filling")
    force = body.impulses.read_and_reset()[0] / (2000 * dt)
    normal = force[2] @ np.array([-math.cos(angle), math.sin(angle)])
    normal = np.concatenate([[normal[: MARGIN + 1].sum()], normal[MARGIN + 1 :]])  # nodes below share with the lowest
    low = np.maximum((np.arange(len(normal)) - 0.5) * cell, 0.0)  # what the nodes of a row stand for
    high = np.minimum((np.arange(len(normal)) + 0.5) * cell, height)
    exact = np.where(low < height, DENSITY * G * (high - low) * (height - 0.5 * (low + high)), 0.0) / math.cos(angle)
    fifths = [(low >= a * height - 1e-9) & (low < (a + 0.2) * height - 1e-9) for a in (0.0, 0.2, 0.4, 0.6)]
    worst = max(abs(normal[part].sum() / exact[part].sum() - 1.0) for part in fifths)
    whole = 0.5 * DENSITY * G * height**2
    return normal.sum() / exact.sum(), worst, force[0, :, 0].sum() / whole


@pytest.mark.parametrize("angle", [15.0, -15.0])
def test_a_liquid_presses_on_an_inclined_wall_as_on_a_straight_one(angle):
    """Within 1 % of the hydrostatic force on 40 cells of height, in each fifth but the highest, too."""
    inclined, fifths, straight = trough(angle, 0.025)
    assert inclined == pytest.approx(1.0, abs=0.01)
    assert straight == pytest.approx(1.0, abs=0.01)
    assert fifths < 0.01


def test_its_error_falls_with_the_cells():
    assert 0.008 < abs(trough(15.0, 0.05)[0] - 1.0) < 0.015  # 1.1 %; 0.6 % on half the cells


def test_sand_that_lands_on_a_wall_gets_back_no_more_than_the_wall_has_stored():
    """A layer of a point thrown at an incline: it turns within three steps, and not all of its energy comes back."""
    down, up = np.array([1.0, -1.0]) / math.sqrt(2.0), np.array([1.0, 1.0]) / math.sqrt(2.0)
    particles, grid = block(width=0.6, height=0.05, cell=0.05, box=(3.0, 3.0))
    place, base = particles.arrays()["position"], np.array([0.6, 2.0])
    speed, step = np.tile(-0.1 * up, (len(place), 1)), 1e-4
    change(particles, position=base + place[:, :1] * down + place[:, 1:] * up, velocity=speed)
    incline = Surface("incline", (tuple(base - 0.5 * down), tuple(base + 2.0 * down)), Coulomb(0.0))
    body = solver(particles, grid, UniformGimp(0.5), Elastic(1.0, 0.0), surfaces=(incline,))
    energy = []
    for _ in range(20):
        body.advance(1, step)
        moving = 0.5 * float(particles.arrays()["mass"] @ (particles.arrays()["velocity"] ** 2).sum(axis=1))
        energy.append((moving, body.surfaces.stored_J(step)))
    moving, stored = np.array(energy).T / (0.5 * particles.arrays()["mass"].sum() * 0.01)
    turn = int(moving.argmin())
    assert moving[turn] < 0.01
    assert 0.3 < stored[turn] < 1.0
    assert turn <= 3 and stored[-1] == 0.0
    assert 0.2 < moving[-1] <= stored[turn]


def test_a_checkpoint_is_taken_over_bit_by_bit_and_one_with_other_weights_gets_those_of_today():
    particles, grid = block(width=0.6, height=0.2, cell=0.05, box=(3.0, 3.0), origin=(0.6, 2.0))
    surfaces = (Surface("floor", ((0.6, 1.99), (1.2, 1.99)), Coulomb(20.0)),)
    body = solver(particles, grid, UniformGimp(0.5), Elastic(2e6, 0.2), surfaces=surfaces)
    body.advance(50, 1e-4, gravity=(G, G))
    traction, seen = values(body.surfaces.traction), values(body.surfaces.seen)
    assert (traction[:, 0] > 0.0).any()
    body.surfaces.restore(traction, seen)
    assert (values(body.surfaces.traction) == traction).all()
    body.surfaces.restore(traction * [1.0, 1.0, 1.0, 7.0], seen)
    assert values(body.surfaces.traction) == pytest.approx(traction, rel=1e-12)
