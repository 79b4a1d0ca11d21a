"""Several outlets, side outlets, ledges and bands of wall friction, on a coarse grid: balances and theory."""

import math

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene.scene import Flow, Mesh, Method, Scene, Walls
from taichi_silo.scene.silo import Insert, Silo
from taichi_silo.simulation.simulation import Simulation

SMOOTH = Walls(kind="smooth", friction_angle_deg=20.0)
SLOW = Flow(speed_m_per_s=0.02, displacement_m=0.012)
SHORT = Method(filling_time_s=0.1, longest_settling_s=0.1)
THREE = (
    {"width_m": 0.08, "position": 0.1},
    {"width_m": 0.08, "position": 0.3, "closes_at_s": 0.2},
    {"width_m": 0.08, "position": 0.1, "wall": "left", "opens_at_s": 0.1},
)
LEDGE = Insert.polygon([(0.0, 0.12), (0.08, 0.12), (0.08, 0.18), (0.0, 0.18)])


class History:
    """A run kept in memory."""

    def __init__(self, silo, walls=SMOOTH, flow=SLOW, method=SHORT):
        runtime.init()
        self.scene = Scene(silo=silo, walls=walls, flow=flow, grid=Mesh(cell_size_m=0.02), method=method)
        simulation = Simulation(self.scene)
        self.model, self.mass = simulation.model, simulation.model.mass
        self.filling, self.flow = list(simulation.fill()), list(simulation.flow())
        self.begun, self.end = self.filling[-1].time_s, simulation.points()
        self.held, self.gone = simulation.above_opening, simulation.discharged
        self.weight = 9.81 * self.mass
        self.alarms = simulation.alarms.found


@pytest.fixture(scope="module")
def gated():
    return History(Silo(width_m=0.4, height_m=0.2, outlet=THREE), flow=Flow(speed_m_per_s=0.05, displacement_m=0.02))


def test_what_left_by_each_outlet_sums_to_what_is_missing(gated):
    for record in gated.flow:
        assert sum(record.outlets_kg_per_m) == pytest.approx(record.discharged_kg_per_m, rel=1e-12, abs=1e-12)
    assert gated.held + gated.gone == pytest.approx(gated.mass, rel=1e-12)
    assert sum(gated.flow[-1].outlets_kg_per_m) == pytest.approx(gated.mass - gated.held, rel=1e-9)
    assert max(sum(record.outlets_kg_per_m) for record in gated.filling) == 0.0


def test_each_gate_lets_out_what_it_sweeps(gated):
    """Width times the way of the gate, less what dense sand dilates.

    What begins to move sideways, under little pressure, loosens first: that gate runs ahead by a part of a cell.
    """
    way, before = np.zeros(3), 0.0
    for record in gated.flow:
        way += np.array(record.gates) * (record.displacement_m - before)
        before = record.displacement_m
    assert way[0] == pytest.approx(0.02)
    assert way[1] < 0.6 * way[0]  # it closes
    out = np.array(gated.flow[-1].outlets_kg_per_m) / (gated.model.density * 0.08)  # as a way of the gate
    assert np.all(out[:2] > 0.93 * way[:2])
    assert np.all(out[:2] < 1.01 * way[:2])
    assert 0.0 < way[2] - out[2] < 0.1 * 0.02


def test_a_gate_moves_only_while_it_is_open(gated):
    first = next(record for record in gated.flow if record.gates[2] > 0.0)
    assert first.time_s - gated.begun == pytest.approx(0.1, abs=0.01)
    assert [record.gates[0] for record in gated.flow] == [1.0] * len(gated.flow)


def test_forces_on_gates_are_part_of_the_walls_they_close(gated):
    """At rest the side gate bears what its height of the wall would: N of both walls is the same."""
    rest = gated.filling[-10:]
    left, right = (np.mean([getattr(r, f"{wall}_normal_N_per_m") for r in rest]) for wall in ("left", "right"))
    assert left == pytest.approx(right, rel=1e-3)
    floor, _, side = np.mean([r.gates_N_per_m for r in rest], axis=0)
    assert floor == pytest.approx(0.08 / 0.4 * np.mean([r.bottom_force_N_per_m for r in rest]), rel=0.35)
    assert 0.0 < side < left
    for record in gated.flow:
        assert abs(record.residual_N_per_m) < 1e-9 * gated.weight


def test_work_of_gates_that_move_in_different_ways_balances_the_energy(gated):
    """What weight and gates give becomes motion, stress, and what friction takes: never more motion than given."""
    gained = sum(record.kinetic_gain_J_per_m for record in gated.flow)
    given = sum(record.work_J_per_m for record in gated.flow)
    assert 0.0 <= gained < given
    assert not gated.alarms


@pytest.fixture(scope="module")
def ledge():
    silo = Silo(width_m=0.24, height_m=0.36, outlet={"width_m": 0.12, "position": "right"}, inserts=(LEDGE,))
    return History(silo, flow=Flow(speed_m_per_s=0.05, displacement_m=0.03))


def test_a_ledge_bears_the_sand_above_it_and_what_settles_beside_it_and_all_forces_carry_the_weight(ledge):
    """The column beside it is twice as high and settles more: it hangs on the sand above the ledge."""
    column = ledge.model.density * 9.81 * 0.08 * 0.18  # over the ledge
    up = np.mean([record.bodies_N_per_m["insert_1"][1] for record in ledge.filling[-10:]])
    assert 1.5 * column < up < 2.1 * column
    for record in ledge.filling + ledge.flow:
        assert abs(record.residual_N_per_m) < 1e-9 * ledge.weight


def test_the_wall_that_bears_a_ledge_feels_less_sand_than_the_other(ledge):
    """By the sand that would press where the ledge stands; what presses on its face is told apart."""
    rest = ledge.filling[-10:]
    left, right = (np.mean([getattr(r, f"{wall}_normal_N_per_m") for r in rest]) for wall in ("left", "right"))
    face = -np.mean([r.bodies_N_per_m["insert_1"][0] for r in rest])
    assert left < right
    assert face < 0.0  # it pushes the sand to the right
    assert left - face == pytest.approx(right, rel=0.02)


def test_no_sand_gets_into_a_ledge_or_is_lost_in_its_corners(ledge):
    x, y = ledge.end["position"].T
    deep = np.minimum(np.minimum(0.08 - x, y - 0.12), 0.18 - y)
    assert deep.max() < 0.1 * 0.02
    assert (x > 0.0).all()
    assert "outside" not in " ".join(ledge.alarms)


@pytest.fixture(scope="module", params=["plane", "round"])
def banded(request):
    walls = Walls(kind="smooth", friction_angle_deg=30.0, bands=({"to_m": 0.3, "friction_angle_deg": 5.0},))
    silo = Silo(width_m=0.24, height_m=0.6, section=request.param)
    return History(silo, walls, Flow(speed_m_per_s=0.02, displacement_m=0.03), Method(filling_time_s=0.3))


def test_t_and_n_of_a_wall_with_a_liner_are_janssens_through_both_bands(banded):
    theory = janssen_of(banded.scene, 0.0, banded.scene.law.rest_pressure_ratio(banded.scene.sand.void_ratio))
    rest = banded.filling[-10:]
    normal, shear = (np.mean([getattr(r, f"{name}_N_per_m") for r in rest]) for name in ("normal", "shear"))
    assert normal == pytest.approx(theory.normal_force_N_per_m, rel=0.05)
    assert shear == pytest.approx(theory.shear_force_N_per_m, rel=0.05)


def test_each_band_mobilises_its_own_friction_also_while_the_grid_sinks(banded):
    profile = np.mean([r.profile[0] for r in banded.flow[-5:]], axis=0)
    height = (np.arange(len(profile)) - 2) * 0.02 - 0.03
    ratio = np.degrees(np.arctan2(profile[:, 1], np.maximum(profile[:, 0], 1e-12)))
    low, high = (height > 0.0) & (height < 0.27), (height > 0.33) & (height < 0.5)
    assert ratio[low] == pytest.approx(5.0, abs=0.2)
    assert ratio[high] == pytest.approx(30.0, abs=0.2)


def test_walls_of_different_friction_share_n_and_not_t():
    walls = Walls(kind="smooth", friction_angle_deg=20.0, bands=({"wall": "left", "friction_angle_deg": 10.0},))
    history = History(Silo(width_m=0.2, height_m=0.4), walls, SLOW)
    rest = history.filling[-10:]
    left, right = ([np.mean([getattr(r, f"{w}_{p}_N_per_m") for r in rest]) for p in ("normal", "shear")]
                   for w in ("left", "right"))  # fmt: skip
    assert left[0] == pytest.approx(right[0], rel=1e-3)  # nothing else pushes the sand sideways
    assert math.degrees(math.atan2(left[1], left[0])) == pytest.approx(10.0, abs=0.3)
    assert math.degrees(math.atan2(right[1], right[0])) == pytest.approx(20.0, abs=0.3)
