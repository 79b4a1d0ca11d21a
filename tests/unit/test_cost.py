"""What a run will cost is said before it starts."""

import numpy as np
import pytest

from taichi_silo.cli import model_silo
from taichi_silo.mpm import runtime
from taichi_silo.runs import cost_estimate
from taichi_silo.scene.inserts import Insert
from taichi_silo.scene.outlets import Outlet
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Scene, Walls
from taichi_silo.scene.silo import Hopper, Silo
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.studies.sweep.runs import Run, costs


def coarse(walls="very-rough", speed=0.04, displacement=0.004, cell=0.05, **method) -> Scene:
    return Scene(
        walls=model_silo.walls(walls, 0.60),
        grid=Mesh(cell_size_m=cell),
        flow=Flow(speed_m_per_s=speed, displacement_m=displacement),
        method=Method(**method),
        machine={"threads": 1},
    )


def started(scene: Scene) -> Simulation:
    runtime.init()
    return Simulation(scene)


def done(simulation: Simulation) -> Simulation:
    for _record in simulation.run():
        pass
    return simulation


@pytest.mark.parametrize("walls", ["very-rough", "smooth"])
@pytest.mark.parametrize(
    "method", [{}, {"mass_scaling": 4.0}, {"time_step_s": 1e-4}, {"cfl": 0.2}], ids=lambda m: " ".join(m) or "auto"
)
def test_the_number_of_steps_is_known_to_a_tenth(walls, method):
    scene = coarse(walls, **method)
    simulation = done(started(scene))
    assert abs(cost_estimate.steps(scene) / simulation.clock.steps - 1.0) < 0.1


def test_a_given_step_halved_doubles_their_number():
    started(coarse())
    one, two = (cost_estimate.steps(coarse(time_step_s=step)) for step in (1e-4, 0.5e-4))
    assert two == pytest.approx(2 * one, rel=0.04)  # whole steps in each interval


HOPPER = Silo(hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.1))


@pytest.mark.parametrize(
    "silo", [HOPPER, Silo(outlet=Outlet(width_m=0.1)), Silo(width_m=0.2, height_m=0.5, inserts=(
        Insert(kind="polygon", corners_m=((0.075, 0.24), (0.125, 0.24), (0.1, 0.29))),
    ))], ids=["hopper", "outlet", "insert"],
)  # fmt: skip
def test_steps_are_known_to_a_fifth_where_smooth_walls_converge_or_end(silo):
    grid = Mesh(cell_size_m=0.02, points_per_cell=4)
    scene = coarse("smooth", speed=0.02).model_copy(update={"silo": silo, "grid": grid})
    simulation = done(started(scene))
    assert abs(cost_estimate.steps(scene) / simulation.clock.steps - 1.0) < 0.2


def history(silo: Silo, rehearsed: bool, walls="very-rough", a_cell=1, **flow):
    """Forces and points of a run, whose cost was told before or not; whether its filter waited and has acted."""
    changed = {"silo": silo, "grid": Mesh(cell_size_m=0.05, points_per_cell=a_cell)}
    simulation = started(coarse(walls, **{"displacement": 0.001} | flow).model_copy(update=changed))
    if rehearsed:
        assert cost_estimate.rehearse(simulation, seconds=0.05) > 0.0
        assert (simulation.time, simulation.clock.steps, simulation.stage) == (0.0, 0, "filling")
    forces = [(r.time_s, r.bottom_N_per_m, r.normal_N_per_m, r.shear_N_per_m) for r in simulation.run()]
    filtering = simulation.solver.filter
    acted = filtering.ACTIVE and filtering.waits and filtering.path.to_numpy().max() > 0.0
    return np.array(forces), simulation.points(), acted


@pytest.mark.parametrize("silo", [Silo(), HOPPER], ids=["bottom", "hopper"])
def test_a_rehearsal_leaves_the_run_as_it_would_have_been(silo):
    """Bit by bit: forces, points and clock; a hopper's walls let go of what they pressed on."""
    (plain, points, _), (after, points_after, _) = history(silo, False), history(silo, True)
    assert (plain == after).all()
    assert all((points[name] == points_after[name]).all() for name in points)


def test_a_filter_that_waits_for_flow_counts_strain_from_there_rehearsed_or_not():
    slow = {"speed": 0.01, "displacement": 0.004}
    plain, points, acted = history(HOPPER, False, "smooth", 4, **slow)
    after, points_after, _ = history(HOPPER, True, "smooth", 4, **slow)
    assert acted
    assert (plain == after).all()
    assert all((points[name] == points_after[name]).all() for name in points)


@pytest.mark.long
@pytest.mark.parametrize(("walls", "cell", "speed"), [("very-rough", 0.01, 0.005), ("very-rough", 0.005, 0.02)])
def test_the_cost_is_known_to_a_quarter(walls, cell, speed):
    simulation = started(coarse(walls, speed=speed, displacement=0.005, cell=cell))
    expected = cost_estimate.predict(simulation)
    spent = done(simulation).stepping_seconds
    assert abs(expected.core_seconds / spent - 1.0) < 0.25


@pytest.mark.parametrize("half", ["yes", "no"])
def test_a_finished_run_foretells_the_cost_of_its_like_also_of_half_a_silo(half, tmp_path, monkeypatch):
    silo = Silo(width_m=0.2, height_m=0.4, half=half)
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.02), walls=Walls(kind="smooth", friction_angle_deg=19.0),
                  machine=Machine(threads=1))  # fmt: skip
    done, other = Run(scene, tmp_path / "done"), Run(scene, tmp_path / "other")
    computed = scene.points // (2 if half == "yes" else 1)
    scene.machine.start()
    told = {"cost": {"points": computed, "steps": cost_estimate.steps(scene), "seconds": 12.0}}
    monkeypatch.setattr(Run, "finished", property(lambda run: run is done))
    monkeypatch.setattr(Run, "summary", property(lambda run: told if run is done else {}))
    assert costs({"done": done, "other": other}, ["other"])["other"].core_seconds == pytest.approx(12.0)


def falling(longest_s: float) -> Scene:
    silo = Silo(width_m=0.2, height_m=0.2, outlet=Outlet(width_m=0.1))
    return coarse("smooth").model_copy(update={
        "silo": silo, "grid": Mesh(cell_size_m=0.05, points_per_cell=4),
        "flow": Flow(outflow="gravity", longest_s=longest_s),
    })  # fmt: skip


def test_free_outflow_takes_shorter_steps_than_sand_at_rest():
    """They are less than what falls and lands takes, but more than half of it."""
    simulation = started(falling(0.1))
    for _record in simulation.fill():
        pass
    before = simulation.clock.steps
    for _record in simulation.flow():
        pass
    told = (cost_estimate.steps(falling(1.1)) - cost_estimate.steps(falling(0.1))) / 10.0
    assert 0.5 < told / (simulation.clock.steps - before) < 1.3


def test_turns_of_the_filter_are_in_the_cost_of_free_outflow(monkeypatch):
    """Which a rehearsal, of sand at rest, does not have: the fastest point makes one each 0.003 of a cell."""
    simulation = started(falling(1.0))
    monkeypatch.setattr(cost_estimate, "rehearse", lambda *given, **more: 0.0)
    monkeypatch.setattr(cost_estimate, "seconds_of_a_turn", lambda simulation: 0.5)
    expected = 0.5 * np.sqrt(2.0 * 9.81 * 0.05) / (0.003 * 0.05)
    assert cost_estimate.predict(simulation).core_seconds == pytest.approx(expected)


def test_telling_the_cost_of_free_outflow_leaves_the_run_as_it_would_have_been():
    def forces(told: bool):
        simulation = started(falling(0.05))
        if told:
            assert cost_estimate.predict(simulation).core_seconds > 0.0
        found = [(r.time_s, r.bottom_N_per_m, r.normal_N_per_m, r.shear_N_per_m) for r in simulation.run()]
        return np.array(found), simulation.points()

    (plain, points), (after, points_after) = forces(False), forces(True)
    assert (plain == after).all()
    assert all((points[name] == points_after[name]).all() for name in points)
