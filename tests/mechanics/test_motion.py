"""Bodies whose motion is known exactly."""

import math

import numpy as np
import pytest

from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.shapes import Linear, UniformGimp
from taichi_silo.mpm.walls import Coulomb, NoSlip, PlaneWall
from validation.stability.bodies import block, change, solver

pytestmark = pytest.mark.usefixtures("afresh")

G = 9.81
BOTH_SHAPES = [Linear(), UniformGimp(0.5)]


@pytest.mark.parametrize("shape", BOTH_SHAPES, ids=["linear", "ugimp"])
def test_free_fall_is_exact(shape):
    """V = -g t for every point; y = y0 - g dt^2 n (n + 1) / 2; no stress, no reaction, mass kept."""
    law = Elastic(1e6)
    particles, grid = block(width=0.1, height=0.1, cell=0.02, origin=(0.1, 0.5), box=(0.3, 0.7))
    before = particles.arrays()
    dt, n = 1e-4, 2000
    body = solver(particles, grid, shape, law)
    body.advance(n, dt, gravity=(G, G))
    after = particles.arrays()
    assert np.abs(after["velocity"] - [0.0, -G * n * dt]).max() < 1e-11
    fall = after["position"] - before["position"]
    assert np.abs(fall - [0.0, -G * dt**2 * n * (n + 1) / 2]).max() < 1e-11
    assert np.abs(after["stress"]).max() < 1e-6
    assert (after["mass"] == before["mass"]).all()


def test_a_frame_that_moves_changes_nothing_but_the_coordinates():
    law, shape = Elastic(1e6), UniformGimp(0.5)
    ends = []
    for frame in (0.0, -0.3):
        particles, grid = block(width=0.1, height=0.1, cell=0.02, origin=(0.1, 0.3), box=(0.3, 0.5))
        change(particles, velocity=np.random.default_rng(3).normal(0.0, 0.05, (25, 2)))
        solver(particles, grid, shape, law).advance(200, 1e-4, gravity=(G, G), plate_velocity=(frame, frame))
        ends.append(particles.arrays()["position"] + [0.0, frame * 200 * 1e-4])
    assert np.abs(ends[0] - ends[1]).max() < 2e-4  # interpolation differs by where the nodes are
    assert np.abs(ends[0].mean(axis=0) - ends[1].mean(axis=0)).max() < 1e-12


def test_an_elastic_bar_swings_with_its_period():
    """Fixed at one end, free at the other, no lateral strain: T = 4 L / c."""
    law, shape = Elastic(1e6, 0.0), UniformGimp(0.5)
    length, cell, density = 1.0, 0.02, 1500.0
    particles, grid = block(width=length, height=cell * 2, cell=cell, density=density, box=(1.1, 0.08))
    x = particles.arrays()["position"][:, 0]
    shape_of_mode = np.sin(0.5 * math.pi * x / length)
    change(particles, velocity=np.stack([1e-3 * shape_of_mode, 0.0 * x], axis=1))
    wall = PlaneWall("left", 0, -1, grid.node_along(0.0), NoSlip())
    body = solver(particles, grid, shape, law, (wall,))
    c = math.sqrt(law.young_modulus_Pa / density)
    dt = 0.2 * cell / c
    amplitude = []
    for _ in range(1200):
        body.advance(1, dt)
        amplitude.append(particles.velocity.to_numpy()[:, 0] @ shape_of_mode)
    amplitude = np.array(amplitude)
    crossings = np.flatnonzero(np.diff(np.sign(amplitude)))
    exact = crossings + amplitude[crossings] / (amplitude[crossings] - amplitude[crossings + 1])
    period = 2.0 * np.diff(exact).mean() * dt
    assert period == pytest.approx(4.0 * length / c, rel=0.01)
    assert np.abs(amplitude[-300:]).max() > 0.95 * np.abs(amplitude[:300]).max()  # no hidden damping


class TestBlockOnAnIncline:
    """An elastic block without damping, 0.5 m x 0.2 m, placed with the stress that it has when it slides."""

    def slide(self, slope_deg, friction_angle_deg, steps=1500):
        """Acceleration down the slope over g, last velocity [m/s], the wall's tangential impulse over its normal one.

        In the second half of the steps.
        """
        slope, mu = math.radians(slope_deg), math.tan(math.radians(friction_angle_deg))
        law, cell, density = Elastic(2e6, 0.2), 0.05, 1500.0
        particles, grid = block(width=0.5, height=0.2, cell=cell, origin=(0.2, 0.0), box=(2.4, 0.3))
        y = particles.arrays()["position"][:, 1]
        normal = -density * G * math.cos(slope) * (0.2 - y)
        shear = -min(mu, math.tan(slope)) * normal
        change(particles, stress=np.stack([0 * y, normal, 0 * y, shear], axis=1))
        floor = PlaneWall("floor", 1, -1, grid.node_along(0.0), Coulomb(friction_angle_deg))
        body = solver(particles, grid, UniformGimp(0.5), law, (floor,), down=(math.sin(slope), -math.cos(slope)))
        dt, velocities = 3e-4, []
        for _ in range(2):
            body.impulses.read_and_reset()
            body.advance(steps // 2, dt, gravity=(G, G))
            velocities.append(particles.arrays()["velocity"][:, 0].mean())
        along, pressed = body.impulses.read_and_reset()[0][0].sum(axis=0)
        return (velocities[1] - velocities[0]) / (steps // 2 * dt) / G, velocities[1], -along / pressed

    @pytest.mark.parametrize(("slope", "friction"), [(15, 10), (30, 20), (45, 20), (45, 40), (60, 19), (60, 50)])
    def test_it_slides_with_g_sin_minus_mu_cos(self, slope, friction):
        acceleration, _, ratio = self.slide(slope, friction)
        mu = math.tan(math.radians(friction))
        exact = math.sin(math.radians(slope)) - mu * math.cos(math.radians(slope))
        assert acceleration == pytest.approx(exact, rel=0.005)
        assert ratio == pytest.approx(mu, rel=0.005)

    @pytest.mark.parametrize(("slope", "friction"), [(15, 16), (30, 31), (40, 42)])
    def test_it_stays_where_friction_suffices_by_a_degree(self, slope, friction):
        """It would gain 1.3 m/s at 15 degrees without friction; what friction gives is what the slope asks for."""
        acceleration, velocity, ratio = self.slide(slope, friction, steps=3000)
        assert abs(velocity) < 2e-3
        assert abs(acceleration) < 1e-3
        assert ratio == pytest.approx(math.tan(math.radians(slope)), rel=0.005)

    def test_it_slides_freely_without_friction(self):
        acceleration, _, ratio = self.slide(25, 0)
        assert acceleration == pytest.approx(math.sin(math.radians(25)), rel=1e-9)
        assert ratio == 0.0


def test_sand_may_leave_a_coulomb_wall_but_not_a_very_rough_one():
    law, shape = Elastic(1e5, 0.0), UniformGimp(0.5)
    speeds = {}
    for name, contact in (("coulomb", Coulomb(20.0)), ("very rough", NoSlip())):
        particles, grid = block(width=0.1, height=0.1, cell=0.02, box=(0.3, 0.1))
        change(particles, velocity=np.tile([0.5, 0.0], (25, 1)))
        wall = PlaneWall("left", 0, -1, grid.node_along(0.0), contact)
        body = solver(particles, grid, shape, law, (wall,))
        body.advance(50, 1e-4)
        speeds[name] = particles.arrays()["velocity"][:, 0]
    assert np.abs(speeds["coulomb"] - 0.5).max() < 1e-12
    assert speeds["very rough"].min() < 0.1


def test_how_dense_sand_is_below_the_floor_counts_no_more():
    """It has passed an outlet, whose gate packs it; the densest sand is looked for above."""
    particles, grid = block(width=0.4, height=0.4, cell=0.1, origin=(0.0, 0.0), box=(0.4, 0.6))
    volume, place = particles.arrays()["volume"].copy(), particles.arrays()["position"].copy()
    densest, gone = 3, 0
    volume[densest], volume[gone] = 0.8 * volume[densest], 0.5 * volume[gone]
    place[gone, 1] -= 0.06
    change(particles, volume=volume, position=place)
    body = solver(particles, grid, UniformGimp(0.5), Elastic(1e6, 0.0))
    expected = 0.8 * 2650.0 / 1500.0 - 1.0
    assert body.point_sums().void_ratio_low == pytest.approx(expected, rel=1e-12)
