"""A coarse silo (20 mm cells, fast bottom): balances, bounds and stored force curves."""

import math

import numpy as np
import pandas as pd
import pytest

from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.cli import model_silo
from taichi_silo.mpm import runtime
from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.p2g import scatter
from taichi_silo.runs.observers.wall_profiles import wall_stress
from taichi_silo.scene.scene import Flow, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.simulation.wall_forces import LEFT, RIGHT

CASES = [(0.60, "smooth"), (0.60, "very-rough"), (0.90, "smooth"), (0.90, "very-rough")]
CURVES = ("displacement_m", "bottom_N_per_m", "shear_N_per_m", "normal_N_per_m")


def mass_on_grid(solver):
    solver.grid.hold()
    store = Fields(solver.particles, solver.grid, solver.shape, atomic=True)

    @ti.kernel
    def scatter_all():
        for p in range(solver.particles.count):
            scatter(store, solver.transfer, solver.surroundings, p, 0, True, True)

    scatter_all()
    total = float(solver.grid.mass.to_numpy().sum())
    solver.grid.mass.fill(0.0)
    return total


class History:
    """A run kept in memory."""

    def __init__(self, void_ratio, walls, noise_control="column", cell_size=0.02, displacement=0.004):
        runtime.init()
        self.scene = Scene(
            silo=Silo(half="no"),  # left and right are to be compared
            sand=Sand(void_ratio=void_ratio),
            walls=model_silo.walls(walls, void_ratio),
            grid=Mesh(cell_size_m=cell_size),
            flow=Flow(speed_m_per_s=0.02, displacement_m=displacement),
            method=Method(noise_control=noise_control, filling_time_s=0.3, longest_settling_s=0.3),
        )
        simulation = Simulation(self.scene)
        self.mass = simulation.model.mass
        self.filling = list(simulation.fill())
        self.filled = simulation.points()
        self.flow = list(simulation.flow())
        self.end = simulation.points()
        self.mass_on_grid = mass_on_grid(simulation.solver)
        self.all = self.filling + self.flow
        self.weight = self.scene.weight_N_per_m
        self.period = simulation.model.period
        self.names = {wall.name: wall for wall in simulation.solver.walls}


@pytest.fixture(scope="module")
def histories():
    return {case: History(*case) for case in CASES}


@pytest.fixture(params=CASES, ids=lambda case: f"e{case[0]:.2f}-{case[1]}")
def history(request, histories):
    return histories[request.param]


def test_bottom_and_walls_carry_weight_less_what_accelerates_in_every_row(history, tried):
    """P + T + T = W + d(upward momentum)/dt - control force, to 1e-9 of W."""
    for r in history.all:
        carried = r.bottom_N_per_m + r.left_shear_N_per_m + r.right_shear_N_per_m
        assert (
            abs(carried - r.weight_N_per_m - r.momentum_rate_N_per_m + r.noise_control_force_N_per_m)
            < 1e-9 * history.weight
        )
    tried("loads held", "flow of a silo, balance closed to 1e-9 of the weight in every row")


def test_mass_is_exact(history):
    """That of the points, and what the grid receives of it."""
    assert (history.end["mass"] == history.filled["mass"]).all()
    assert history.mass == pytest.approx(history.weight / 9.81, rel=1e-14)
    assert history.mass_on_grid == pytest.approx(history.mass, rel=1e-13)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"e{case[0]:.2f}-{case[1]}")
def test_noise_control_pushes_with_less_than_three_thousandths_of_the_weight_in_steady_flow(case):
    """The bottom gets its speed over the first 3 mm; the swing of that needs another."""
    history = History(*case, displacement=0.006)
    steady = [r.noise_control_force_N_per_m for r in history.flow if r.displacement_m > 0.004]
    assert abs(np.mean(steady)) < 3e-3 * history.weight


def test_displacement_ends_where_it_should(history):
    assert history.flow[-1].displacement_m == pytest.approx(0.004, abs=1e-12)
    bottom = history.end["position"][:, 1].min()
    assert bottom == pytest.approx(history.filled["position"][:, 1].min() - 0.004, abs=5e-4)


def test_left_and_right_are_equal_before_anything_can_localise(history):
    for r in history.filling:
        assert abs(r.left_normal_N_per_m - r.right_normal_N_per_m) < 1e-9 * history.weight


def test_smooth_walls_stay_symmetric_and_slide_at_their_friction_angle(histories):
    for void_ratio, angle in ((0.60, 19.0), (0.90, 12.3)):
        history = histories[void_ratio, "smooth"]
        for r in history.flow:
            assert abs(r.left_normal_N_per_m - r.right_normal_N_per_m) < 1e-9 * history.weight
        sliding = [r.wall_friction_angle_deg for r in history.flow if r.displacement_m > 0.001]
        # the corner node, which the plate lowers, may rest within the cone
        assert np.abs(np.array(sliding) - angle).max() < 0.1
        assert np.mean(sliding) == pytest.approx(angle, abs=0.02)


def test_no_node_ever_pulls_or_leaves_coulombs_cone(histories, tried):
    for void_ratio, angle in ((0.60, 19.0), (0.90, 12.3)):
        for r in histories[void_ratio, "smooth"].all:
            for wall, sign in ((LEFT, 1.0), (RIGHT, -1.0)):
                normal, shear = sign * r.profile[wall, :, 0], r.profile[wall, :, 1]
                assert normal.min() >= 0.0
                assert (np.abs(shear) <= math.tan(math.radians(angle)) * normal * (1 + 1e-9) + 1e-12).all()
        tried("loads held", "flow of a silo, no wall pulls or exceeds its friction in any row")


def test_sand_between_smooth_walls_neither_ratchets_nor_creeps(histories):
    for void_ratio in (0.60, 0.90):
        history = histories[void_ratio, "smooth"]
        below = history.filled["position"][:, 1] < 0.45
        drift = (history.end["void_ratio"] - history.filled["void_ratio"])[below].mean()
        assert abs(drift) < 0.003
        before = np.mean([r.normal_N_per_m for r in history.filling[-10:]])
        after = np.mean([r.normal_N_per_m for r in history.flow[-10:]])
        assert after == pytest.approx(before, rel=0.04)
        rigid = 0.5 * history.mass * 0.02**2
        steady = [r.kinetic_energy_J_per_m / rigid for r in history.flow if r.displacement_m > 0.003]
        assert min(steady) > 0.9 and max(steady) < 1.1
        path = (history.end["path"] - history.filled["path"])[below].mean()
        assert path < 2e-4


@pytest.mark.long
def test_without_noise_control_it_ratchets_and_the_wall_force_is_a_quarter_too_high():
    """The failure and its cure on one grid: the column's own oscillation eats void ratio and raises the pressure."""
    free, controlled = (
        History(0.60, "smooth", noise_control=name, cell_size=0.01, displacement=0.001) for name in ("none", "column")
    )
    below = free.filled["position"][:, 1] < 0.45

    def loss(history):
        return 0.60 - history.end["void_ratio"][below].mean()

    def force(history):
        return np.mean([r.normal_N_per_m for r in history.flow[-20:]])

    assert force(free) > 1.2 * force(controlled)
    assert loss(free) > 3.0 * loss(controlled)
    assert free.end["path"][below].mean() > 5.0 * controlled.end["path"][below].mean()


def test_filling_between_smooth_walls_agrees_with_janssen_at_the_laws_own_pressure_ratio(histories):
    for void_ratio, angle in ((0.60, 19.0), (0.90, 12.3)):
        history = histories[void_ratio, "smooth"]
        scene = history.scene
        theory = Janssen(
            0.2, 0.5, scene.density_kg_per_m3 * 9.81, angle, scene.sand.skeleton().rest_pressure_ratio(void_ratio)
        )
        last = history.filling[-10:]
        assert np.mean([r.normal_N_per_m for r in last]) == pytest.approx(theory.normal_force_N_per_m, rel=0.15)
        assert np.mean([r.shear_N_per_m for r in last]) == pytest.approx(theory.shear_force_N_per_m, rel=0.15)
        assert np.mean([r.bottom_N_per_m for r in last]) == pytest.approx(theory.bottom_force_N_per_m, rel=0.15)
        height, stress = wall_stress(np.mean([r.profile for r in last], axis=0)[LEFT, :31], 0.02, closed=False)
        inside = (height > 0.05) & (height < 0.42)
        assert stress[inside, 0] == pytest.approx(theory.normal_stress_Pa(0.5 - height[inside]), rel=0.15)


def test_dense_sand_between_very_rough_walls_loses_its_bottom_force_at_once(histories):
    history = histories[0.60, "very-rough"]
    rest = history.filling[-1]
    first = [r for r in history.flow if r.displacement_m < 0.001]
    assert min(r.bottom_N_per_m for r in first) < 0.5 * rest.bottom_N_per_m
    shear = [r.shear_N_per_m for r in history.flow]
    assert max(shear) > 1.2 * rest.shear_N_per_m
    assert shear[-1] < max(shear)
    assert history.flow[-1].normal_N_per_m > 1.2 * rest.normal_N_per_m
    x = history.filled["position"][:, 0]
    growth = history.end["void_ratio"] - history.filled["void_ratio"]
    at_wall, core = growth[x < 0.02], growth[np.abs(x - 0.1) < 0.03]
    assert at_wall.min() > 0.0
    assert at_wall.mean() > 2.0 * abs(core.mean())


def test_loose_sand_between_very_rough_walls_contracts_there(histories):
    history = histories[0.90, "very-rough"]
    place = history.filled["position"]
    near_wall = (place[:, 0] < 0.02) & (place[:, 1] > 0.05) & (place[:, 1] < 0.4)
    assert (history.end["void_ratio"] - history.filled["void_ratio"])[near_wall].mean() < -0.005


def test_force_curves_are_those_stored(history, data, renew_curves):
    """Renew with `pytest --renew-curves` (see tests/data/README.md)."""
    scene = history.scene
    file = data / f"coarse_silo_e{scene.sand.void_ratio:.2f}_{scene.walls.kind}.csv"
    now = pd.DataFrame([{name: getattr(r, name) for name in CURVES} for r in history.all])
    thinned = now.groupby(np.arange(len(now)) // 5).mean()
    if renew_curves:
        thinned.to_csv(file, index=False, float_format="%.6g")
    stored = pd.read_csv(file)
    size = history.weight
    for name in CURVES[1:]:
        assert len(stored) == len(thinned)
        assert np.abs(stored[name] - thinned[name]).max() < 2e-3 * size, name


def test_sand_with_memory_fills_and_flows_between_smooth_walls_as_janssen_says():
    """Its memory starts along the filling strain, so that it neither hangs nor overshoots."""
    runtime.init()
    scene = Scene(
        sand=Sand(law="intergranular"),
        walls=Walls(kind="smooth", friction_angle_deg=19.0), grid=Mesh(cell_size_m=0.025),
        flow=Flow(speed_m_per_s=0.02, displacement_m=0.002), method=Method(filling_time_s=0.3, longest_settling_s=0.3),
    )  # fmt: skip
    simulation = Simulation(scene)
    assert simulation.points()["intergranular"] == pytest.approx(np.tile([0.0, -1e-4, 0.0, 0.0], (160, 1)))
    records = list(simulation.run())
    theory = Janssen(0.2, 0.5, scene.density_kg_per_m3 * 9.81, 19.0, scene.sand.skeleton().rest_pressure_ratio(0.60))
    filled = np.mean([r.normal_N_per_m for r in records if r.stage == "filling"][-10:])
    flowing = np.mean([r.normal_N_per_m for r in records][-5:])
    assert filled == pytest.approx(theory.normal_force_N_per_m, rel=0.1)
    assert flowing == pytest.approx(filled, rel=0.05)
    size = np.linalg.norm(simulation.points()["intergranular"] * [1, 1, 1, np.sqrt(2)], axis=1)
    assert size.max() <= 1e-4 * (1 + 1e-9)
