"""The three ways to loop over one and the same formulas give one and the same step."""

import numpy as np
import pytest

from taichi_silo.cli import model_silo
from taichi_silo.mpm import runtime
from taichi_silo.scene.scene import Flow, Mesh, Method, Scene, Silo
from taichi_silo.scene.silo import Hopper
from taichi_silo.simulation.simulation import Simulation

pytestmark = pytest.mark.usefixtures("all_cores")
SCENE = Scene(
    silo=Silo(width_m=0.1, height_m=0.2, half="no"),
    grid=Mesh(cell_size_m=0.01),
    flow=Flow(speed_m_per_s=0.02, displacement_m=0.002),
)


def state_after(steps, threads=1, shared=None, walls="very-rough", shape="ugimp", per_cell=1, silo=None, **method):
    runtime.init(threads=threads)
    grid, variant = Mesh(cell_size_m=0.01, shape=shape, points_per_cell=per_cell), Method(**method)
    silo = silo or SCENE.silo
    scene = SCENE.model_copy(
        update={"walls": model_silo.walls(walls, 0.60), "grid": grid, "method": variant, "silo": silo}
    )
    simulation = Simulation(scene)
    if shared:
        whole = simulation.solver
        simulation.solver = type(whole)(
            whole.particles, simulation.grid, whole.shape, whole.law, whole.walls, whole.control,
            shared=True, surfaces=simulation.surfaces, **variant.solver_options(),
        )  # fmt: skip
    simulation.solver.advance(steps, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
    return simulation.particles.arrays(), simulation.solver.impulses.read_and_reset()


@pytest.mark.parametrize("how", [{"threads": 2}, {"threads": 2, "shared": True}], ids=["two threads", "atomic sums"])
def test_loops_agree_about_a_hopper(how):
    """What its walls give is booked where nodes get it, whoever steps them."""
    silo = Silo(width_m=0.1, height_m=0.2, hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.05))
    alone, (reaction, _) = state_after(100, walls="smooth", silo=silo)
    other, (reaction_other, _) = state_after(100, walls="smooth", silo=silo, **how)
    assert np.abs(reaction[4:]).max() > 0.0
    for name, field in alone.items():
        assert np.abs(field - other[name]).max() <= 1e-9 * np.abs(field).max(), name
    assert np.abs(reaction - reaction_other).max() < 1e-9 * np.abs(reaction).max()


@pytest.mark.parametrize("walls", ["smooth", "very-rough"])
@pytest.mark.parametrize(
    "how", [{"threads": 2}, {"threads": 2, "shared": True}], ids=["two threads", "two threads with atomic sums"]
)
def test_loops_agree_to_round_off(how, walls):
    alone, (reaction, control) = state_after(100, walls=walls)
    other, (reaction_other, control_other) = state_after(100, walls=walls, **how)
    for name, field in alone.items():
        assert np.abs(field - other[name]).max() <= 1e-9 * np.abs(field).max(), name
    assert np.abs(reaction - reaction_other).max() < 1e-9 * np.abs(reaction).max()
    assert np.abs(control - control_other).max() < 1e-9 * np.abs(reaction).max()


@pytest.mark.parametrize(
    "how", [{"threads": 2}, {"threads": 2, "shared": True}], ids=["two threads", "two threads with atomic sums"]
)
@pytest.mark.parametrize(
    "variant",
    [
        {"shape": "cpdi", "transfer": "xpic", "stress_filter": "null-space", "per_cell": 4},
        {"shape": "cpgimp", "stress_update": "first", "stress_filter": "smoothing"},
        {"shape": "bspline", "transfer": "apic", "stress_update": "modified"},
    ],
    ids=["cpdi xpic null-space", "cpgimp first smoothing", "bspline apic modified"],
)
def test_loops_agree_whatever_the_phases_of_the_step(how, variant):
    alone, (reaction, _) = state_after(100, **variant)
    other, (reaction_other, _) = state_after(100, **variant, **how)
    for name, field in alone.items():
        assert np.abs(field - other[name]).max() <= 1e-9 * np.abs(field).max(), name
    assert np.abs(reaction - reaction_other).max() < 1e-9 * np.abs(reaction).max()


def test_one_thread_and_two_threads_each_repeat_themselves_bit_by_bit():
    for threads in (1, 2):
        first, second = (state_after(100, threads=threads)[0] for _ in range(2))
        assert all((first[name] == second[name]).all() for name in first)


def test_steps_may_be_cut_into_launches_at_will():
    scene_state = []
    for parts in ((400,), (150, 250)):
        runtime.init()
        simulation = Simulation(SCENE)
        for part in parts:
            simulation.solver.advance(part, 2e-5, gravity=(9.81, 9.81))
        scene_state.append(simulation.particles.arrays())
    assert all((scene_state[0][name] == scene_state[1][name]).all() for name in scene_state[0])


def test_a_grid_with_too_few_copies_of_its_sums_is_refused():
    runtime.init(threads=2)
    simulation = Simulation(SCENE)
    whole = simulation.solver
    with pytest.raises(ValueError, match="copies"):
        type(whole)(whole.particles, type(whole.grid)(0.1, whole.grid.height, 0.01), whole.shape, whole.law)
