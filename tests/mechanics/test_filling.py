"""Sand that is filled in by its growing weight is loaded steadily, so that it ends where the law alone brings it."""

import numpy as np
import pytest

from taichi_silo import Averaging, Flow, Machine, Mesh, Method, Scene, Silo, Walls, named_sand, run
from taichi_silo.simulation.filling import grown
from taichi_silo.simulation.outflow import duration, start
from validation.error_bars import compressed


def filled(folder, void_ratio: float, seconds: float = 0.5, silo: Silo | None = None, cell: float = 0.02):
    """Numbers after filling between frictionless walls, over the weight."""
    scene = Scene(
        silo=silo or Silo(), sand=named_sand("karlsruhe", void_ratio),
        walls=Walls(kind="smooth", friction_angle_deg=0.0), grid=Mesh(cell_size_m=cell),
        averaging=Averaging(characteristic_length_m=0.0),
        flow=Flow(speed_m_per_s=0.02, displacement_m=1e-4), method=Method(filling_time_s=seconds),
        machine=Machine(threads=1),
    )  # fmt: skip
    found = run(scene, folder, film=False, progress=False).summary["filling"]
    return found["normal_N_per_m"], found["bottom_N_per_m"], compressed(scene)


@pytest.mark.parametrize("void_ratio", [0.60, 0.90])
def test_a_frictionless_wall_bears_what_compression_without_lateral_strain_makes(void_ratio, tmp_path):
    normal, bottom, truth = filled(tmp_path / "run", void_ratio)
    assert normal == pytest.approx(truth["N_filled"], rel=1.5e-3)  # 1.8 % above with a ramp that has kinks
    assert bottom == pytest.approx(truth["P_filled"], rel=1e-4)


@pytest.mark.parametrize("height", [0.44, 0.46])
def test_so_it_does_in_a_silo_that_no_square_cells_fit(height, tmp_path):
    """Cells of 21.7 mm are 22 or 21.9 mm high there: that of 0.44 m has 20 rows, that of 0.46 m has 21."""
    silo = Silo(width_m=0.217, height_m=height)
    normal, bottom, truth = filled(tmp_path / "run", 0.60, silo=silo, cell=0.0217)
    assert normal == pytest.approx(truth["N_filled"], rel=1.5e-3)
    assert bottom == pytest.approx(truth["P_filled"], rel=1e-4)


def test_the_weight_and_its_rate_grow_without_a_jump():
    assert grown(0.0) == 0.0 and grown(1.0) == 1.0 and grown(0.5) == pytest.approx(0.5)
    for end, into in ((0.0, 1e-4), (1.0, -1e-4)):
        assert abs(grown(end + into) - grown(end)) < 1e-10


@pytest.mark.parametrize("speed", [0.002, 0.02, 0.2])
def test_the_bottom_starts_with_a_hundredth_of_gravity_at_most(speed):
    scene = Scene(flow=Flow(speed_m_per_s=speed))
    period = 0.02
    accelerations = [6.0 * part * (1.0 - part) * speed / start(scene, period) for part in (0.25, 0.5, 0.75)]
    assert max(accelerations) <= 0.0101 * 9.81
    assert start(scene, period) >= 5.0 * period


@pytest.mark.parametrize(("speed", "scaling"), [(0.002, 1.0), (0.02, 1.0), (0.2, 1.0), (0.032, 100.0)])
def test_the_flow_lasts_as_long_as_its_bottom_needs_for_the_way(speed, scaling):
    """Also where the way ends before the bottom has its speed: the integral of the speed is the displacement."""
    scene = Scene(flow=Flow(speed_m_per_s=speed, displacement_m=0.002), method=Method(mass_scaling=scaling))
    whole, begun = duration(scene, 0.02), start(scene, 0.02)
    part = np.clip(np.linspace(0.0, whole, 100_001) / begun, 0.0, 1.0)
    way = np.trapezoid(speed * part**2 * (3.0 - 2.0 * part), dx=whole / 100_000)
    assert way == pytest.approx(0.002, rel=1e-3)
