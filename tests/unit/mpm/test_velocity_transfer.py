"""Transfers and orders of the stress update: what each keeps, and what each loses."""

import itertools

import numpy as np
import pytest

from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.solver import STRESS_UPDATES
from taichi_silo.mpm.velocity_transfer import TRANSFERS, Blend
from validation.stability.bodies import block, change, solver
from validation.stability.conservation import FreeBlock

LAW = Elastic(1e6, 0.2)
COMBINATIONS = [
    (transfer, update)
    for transfer, update in itertools.product(TRANSFERS, STRESS_UPDATES)
    if not (TRANSFERS[transfer].SECOND_TRANSFER and update != "last")
]


def moving_block(transfer, update="last", shape="ugimp", velocity=None):
    kind = SHAPES[shape](0.25)
    particles, grid = block(
        width=0.4, height=0.4, cell=0.1, points_per_axis=2, origin=(0.3, 0.3), box=(1.0, 1.0),
        extra=Particles.extras(LAW, kind, transfer),
    )  # fmt: skip
    place = particles.arrays()["position"]
    noise = np.random.default_rng(4).normal(0.0, 0.1, place.shape)
    change(particles, velocity=noise if velocity is None else velocity(place))
    return particles, solver(particles, grid, kind, LAW, transfer=transfer, stress_update=update)


@pytest.mark.parametrize(("transfer", "update"), COMBINATIONS)
def test_every_combination_keeps_mass_and_momentum(transfer, update):
    particles, body = moving_block(TRANSFERS[transfer](), update)
    before = particles.arrays()
    body.advance(50, 2e-4)
    after = particles.arrays()
    assert (after["mass"] == before["mass"]).all()
    size = before["mass"] @ np.abs(before["velocity"]).sum(axis=1)
    assert np.abs(after["mass"] @ after["velocity"] - before["mass"] @ before["velocity"]).max() < 1e-13 * size


@pytest.mark.parametrize(
    ("transfer", "shape"),
    [(name, "ugimp") for name in TRANSFERS] + [("flip", name) for name in SHAPES if name != "ugimp"],
)
def test_a_body_that_flies_goes_on_flying(transfer, shape):
    def flight(place):
        return np.tile([0.3, -0.2], (len(place), 1))

    particles, body = moving_block(TRANSFERS[transfer](), shape=shape, velocity=flight)
    start = particles.arrays()["position"]
    body.advance(100, 2e-4)
    now = particles.arrays()
    assert np.abs(now["velocity"] - [0.3, -0.2]).max() < 1e-12
    assert np.abs(now["position"] - start - [0.3 * 0.02, -0.2 * 0.02]).max() < 1e-12
    assert np.abs(now["stress"]).max() < 1e-6


def velocity_after(transfer, dt=0.0, steps=1):
    """Velocities of the points of a block that starts with random ones."""
    particles, body = moving_block(transfer)
    if steps:
        body.advance(steps, dt)
    return particles.arrays()["velocity"]


def test_pic_smears_what_flip_keeps():
    first = np.square(velocity_after(TRANSFERS["flip"](), steps=0)).sum()
    left = {name: np.square(velocity_after(TRANSFERS[name]())).sum() for name in ("flip", "pic", "blend", "xpic")}
    assert left["flip"] == pytest.approx(first, rel=1e-12)
    assert left["pic"] < 0.3 * first
    assert left["pic"] < left["xpic"] < first
    assert 0.85 * first < left["blend"] < first


def test_xpic_leaves_twice_what_pic_leaves_less_what_pic_leaves_of_that():
    """V becomes 2 P V - P P V."""
    once, twice = (velocity_after(TRANSFERS["pic"](), steps=count) for count in (1, 2))
    assert np.abs(velocity_after(TRANSFERS["xpic"]()) - (2.0 * once - twice)).max() < 1e-13


def test_blend_is_a_weighted_mean_of_flip_and_pic():
    flip, pic, blend = (velocity_after(t, 1e-4) for t in (TRANSFERS["flip"](), TRANSFERS["pic"](), Blend(0.3)))
    assert np.abs(blend - 0.7 * flip - 0.3 * pic).max() < 1e-14


@pytest.mark.parametrize("name", ["apic", "gradient"])
def test_transfers_with_gradients_carry_a_linear_velocity_field_unchanged(name):
    """Once the gradient is known, a rotation or a shear is neither smeared nor turned."""

    def shear(place):
        return np.stack([2.0 * (place[:, 1] - 0.5), -1.0 * (place[:, 0] - 0.5)], axis=1)

    particles, body = moving_block(TRANSFERS[name](), velocity=shear)
    change(particles, affine=np.tile([0.0, 2.0, -1.0, 0.0], (particles.count, 1)))
    before = particles.arrays()["velocity"]
    body.advance(1, 0.0)
    after = particles.arrays()
    assert np.abs(after["velocity"] - before).max() < 1e-12
    assert np.abs(after["affine"] - [0.0, 2.0, -1.0, 0.0]).max() < 1e-6


def test_angular_momentum_is_kept_by_affine_points_and_lost_by_pic():
    def kept(name):
        case = FreeBlock(name)
        case.push(spin=2.0)
        first = case.momentum()[2]
        case.body.advance(300, case.dt)
        return abs(case.momentum()[2] / first - 1.0)

    assert kept("apic") < 0.01
    assert kept("pic") > 0.5


def test_updating_the_stress_last_damps_and_updating_it_first_does_not():
    """Strain from velocities that have been to the nodes and back dissipates, with a rate proportional to the step."""

    def left(update, part=1):
        case = FreeBlock("flip", update)
        case.push(swing=1e-3)
        first = case.energy()
        case.body.advance(1000 * part, case.dt / part)
        return case.energy() / first

    assert left("last") < 0.5
    assert left("last", 4) > 0.75
    assert abs(left("first") - 1.0) < 0.06
    assert abs(left("modified") - 1.0) < 0.06


def test_orders_that_do_not_exist_are_refused():
    with pytest.raises(ValueError, match="'later'; it must be one of last, first, modified"):
        moving_block(TRANSFERS["flip"](), "later")
    with pytest.raises(ValueError, match="it must be 'last'"):
        moving_block(TRANSFERS["xpic"](), "first")
