"""The noise control holds the wall force in flow, whatever wall, slenderness, sand, cells and speed."""

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.mpm.frozen import replaced
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.scene import sands
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Sand, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation


def filled_and_flowing(angle, sand=None, slenderness=2.5, cell=0.01, speed=0.005, until=0.003):
    """(P, T, N) over the weight after filling and at the end, and the change of the core's void ratio."""
    runtime.init()
    scene = Scene(
        silo=Silo(width_m=0.2, height_m=0.2 * slenderness), sand=sand or Sand(),
        walls=Walls(kind="smooth", friction_angle_deg=angle) if angle else Walls(kind="very-rough"),
        grid=Mesh(cell_size_m=cell), averaging=Averaging(characteristic_length_m=0.0),
        flow=Flow(speed_m_per_s=speed, displacement_m=until), machine=Machine(threads=1),
    )  # fmt: skip
    simulation = Simulation(scene)
    periods = []
    cores = []
    for stage in (simulation.fill(), simulation.flow()):
        last = list(stage)[-scene.output.records_per_period :]
        columns = ("bottom_N_per_m", "shear_N_per_m", "normal_N_per_m")
        periods.append(np.mean([[getattr(row, name) for name in columns] for row in last], axis=0))
        points = simulation.points()
        x, y = (points["position"] / (0.2, scene.silo.height_m)).T
        cores.append(points["void_ratio"][(np.abs(x - 0.5) < 0.25) & (y > 0.2) & (y < 0.8)].mean())
    return *(one / scene.weight_N_per_m for one in periods), cores[1] - cores[0]


def holds(angle, **scene):
    filled, flowing, swelling = filled_and_flowing(angle, **scene)
    assert flowing[2] == pytest.approx(filled[2], rel=0.03)
    assert abs(swelling) < 0.001


def test_walls_of_30_degrees():
    holds(30.0)


@pytest.mark.long
@pytest.mark.parametrize("angle", [5.0, 12.0, 20.0, 22.0, 25.0, 35.0, 40.0])
def test_walls_of_any_friction_between_which_no_zones_form(angle):
    holds(angle)


@pytest.mark.long
@pytest.mark.parametrize("angle", [19.0, 30.0])
@pytest.mark.parametrize("slenderness", [1.0, 5.0, 8.0, 12.0])
def test_silos_as_high_as_wide_to_twelve_times_as_high(angle, slenderness):
    holds(angle, slenderness=slenderness)


@pytest.mark.long
@pytest.mark.parametrize("sand", sorted(published()))
def test_all_sands(sand):
    holds(28.0, sand=sands.sand(sand, 0.70))


@pytest.mark.long
@pytest.mark.parametrize("cell, speed", [(0.005, 0.005), (0.0025, 0.01), (0.01, 0.002), (0.01, 0.01)])
def test_fine_cells_and_other_speeds(cell, speed):
    holds(30.0, cell=cell, speed=speed, until=0.002)


@pytest.mark.long
def test_between_very_rough_walls_twice_its_strength_changes_nothing(monkeypatch):
    """So it does not bend the answer."""
    once, _, _ = filled_and_flowing(None, until=0.0005)
    usual = NoiseControl.for_column

    def doubled(*args):
        control = usual(*args)
        return replaced(control, drag=2.0 * control.drag, filling_drag=2.0 * control.filling_drag)

    monkeypatch.setattr(NoiseControl, "for_column", doubled)
    twice, _, _ = filled_and_flowing(None, until=0.0005)
    assert twice == pytest.approx(once, rel=0.005)
