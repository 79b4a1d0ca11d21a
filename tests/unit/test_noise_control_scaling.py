"""How strong the noise control is in a scene: it follows the column's period, its height, and what its walls hold."""

import math

import numpy as np
import pytest

from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.scene.bands import Band
from taichi_silo.scene.scene import Mesh, Sand, Scene, Silo, Walls
from taichi_silo.scene.silo import Outlet
from taichi_silo.simulation.time_scales import grip, noise_control


@pytest.mark.parametrize(("angle", "held"), [(5.0, 0.0), (30.0, 0.0), (45.0, 1.0), (60.0, 1.0)])
def test_walls_hold_sand_from_its_critical_friction_angle_on_and_wholly_from_45_degrees(angle, held):
    assert grip(Scene(walls=Walls(kind="smooth", friction_angle_deg=angle))) == pytest.approx(held)


def test_between_them_the_hold_grows_with_the_coefficient_of_friction_and_a_band_counts():
    halfway = math.degrees(math.atan(0.5 * (math.tan(math.radians(30.0)) + 1.0)))
    assert grip(Scene(walls=Walls(kind="smooth", friction_angle_deg=halfway))) == pytest.approx(0.5)
    lined = Walls(kind="smooth", friction_angle_deg=20.0, bands=(Band(wall="left", friction_angle_deg=halfway),))
    assert grip(Scene(walls=lined)) == pytest.approx(0.5)


def test_sand_with_a_steep_critical_angle_is_held_by_very_rough_walls_alone():
    assert grip(Scene(sand=Sand(void_ratio=0.9))) == 1.0, "loose sand is packed, too"
    sand = Sand(critical_friction_angle_deg=50.0)
    assert grip(Scene(sand=sand, walls=Walls(kind="smooth", friction_angle_deg=45.0))) == 0.0
    assert grip(Scene(sand=sand)) == 1.0


@pytest.mark.parametrize(("width", "held"), [(0.08, 0.0), (0.1, 0.0), (0.15, 0.5), (0.18, 0.8)])
def test_above_an_outlet_of_less_than_half_the_floor_the_usual_drag_is_enough(width, held):
    assert grip(Scene(silo=Silo(outlet=Outlet(width_m=width)))) == pytest.approx(held)


def test_of_a_round_silo_the_area_of_the_floor_counts():
    round_one = Silo(section="round", outlet=Outlet(width_m=0.16))
    assert grip(Scene(silo=round_one)) == pytest.approx(2.0 * 0.64 - 1.0)


def test_on_few_cells_the_drag_is_no_stronger_than_a_step_allows():
    """An explicit drag of a tenth in a step leaves the stable step nearly as it is; four times as much makes energy."""
    few = Scene(silo=Silo(height_m=0.4), grid=Mesh(cell_size_m=0.05))
    smooth = few.model_copy(update={"walls": Walls(kind="smooth", friction_angle_deg=20.0)})
    assert noise_control(few, 0.02) == noise_control(smooth, 0.02)


def test_in_flow_very_rough_walls_get_four_times_the_drag_of_smooth_ones_and_a_column_of_eight_widths_twice():
    smooth, rough = (noise_control(Scene(walls=walls), 0.02) for walls in (
        Walls(kind="smooth", friction_angle_deg=20.0), Walls()))  # fmt: skip
    assert rough.rates("flow") == pytest.approx((4.0 * smooth.drag, 0.0))
    for stage in ("filling", "start"):
        assert rough.rates(stage) == smooth.rates(stage)
    high = Scene(silo=Silo(height_m=1.6), walls=Walls(kind="smooth", friction_angle_deg=20.0))
    assert noise_control(high, 0.02).drag == pytest.approx(2.0 * smooth.drag)


def test_drag_towards_the_recent_mean_weighs_on_a_slow_swing_as_inertia():
    """With m x'' = -k x - m d (x' - mean), for a period well above the memory: T = T_0 sqrt(1 + d tau)."""
    control = NoiseControl(drag=1000.0, memory_time=0.001, flow_strength=3.0)
    mean, x, v, dt, crossings = 0.0, 1.0, 0.0, 1e-5, []
    for step in range(60000):
        a = -((2.0 * math.pi / 0.1) ** 2) * x - control.rates("flow")[0] * (v - mean)
        mean += dt / control.memory_time * (v - mean)
        v += dt * a
        if x * (x + dt * v) < 0.0:
            crossings.append(step * dt)
        x += dt * v
    assert 2.0 * np.diff(crossings).mean() == pytest.approx(0.1 * control.slows(), rel=0.02)
