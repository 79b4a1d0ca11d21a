"""The user's choices of method: flags, files, warnings, mass scaling, and the sand that leaves."""

import inspect

import numpy as np
import pytest

from taichi_silo.cli import catalogue
from taichi_silo.cli.flags import with_method_flags
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.scene import known_limits
from taichi_silo.scene.method_options import MethodOptions
from taichi_silo.scene.outlets import Opening
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Scene, Silo, Walls
from taichi_silo.simulation.discharge import Discharge
from taichi_silo.simulation.simulation import Simulation
from validation.stability.bodies import block, change

COARSE = {"silo": Silo(width_m=0.1, height_m=0.2), "grid": Mesh(cell_size_m=0.02), "machine": Machine(threads=1)}


@pytest.mark.parametrize(
    "name", ["mass_flow", "four_cases", "noise_control", "element_test", "paper_element_tests",
             "plane_strain_compression"],
)  # fmt: skip
def test_every_scenario_has_flags_for_the_method(name):
    found = set(inspect.signature(with_method_flags(catalogue.load(name))).parameters)
    assert {"shape", "transfer", "stress_update", "filter", "time_step", "cfl", "mass_scaling"} <= found


@pytest.mark.parametrize(
    ("flags", "sentence"),
    [
        (("--shape", "quadratic"), "shape is quadratic"),
        (("--transfer", "flop"), "transfer is flop"),
        (("--time-step", "soon"), "time step is soon; it must be auto, or a number of seconds above 0"),
        (("--time-step", "-1e-5"), "time_step_s is -1e-05; it must be at least 1e-09"),
        (("--cfl", "3"), "cfl is 3.0; it must be at least 0.0001 and at most 2"),
        (("--cfl", "0.3", "--time-step", "1e-5"), "cfl is 0.3; it cannot be given together with a time step"),
        (("--mass-scaling", "0.5"), "mass_scaling is 0.5; it must be at least 1"),
        (("--transfer", "xpic", "--stress-update", "first"), "stress update is first; with the transfer xpic"),
        (("--filter", "median"), "stress_filter is median"),
    ],
)
def test_impossible_choices_are_refused_in_one_sentence(flags, sentence, said, tmp_path):
    code, _, err = said("run", "mass_flow", *flags, "--output", tmp_path / "run")
    assert code == 2 and err.count("\n") == 1
    assert sentence in err
    assert not (tmp_path / "run").exists()


def test_a_choice_goes_through_the_whole_of_an_element_test(said, tmp_path):
    code, _, err = said(
        "run", "element_test", "triaxial", "--through", "mpm", "--shape", "cpdi", "--transfer", "apic", "--filter",
        "null-space", "--strain", "0.02", "--output", tmp_path / "run",
    )  # fmt: skip
    assert code == 0, err
    words = (tmp_path / "run" / "run.toml").read_text()
    for line in ('shape = "cpdi"', 'transfer = "apic"', 'stress_filter = "null-space"'):
        assert line in words


def test_the_defaults_are_those_that_the_map_recommends_and_warn_of_nothing():
    assert MethodOptions() == MethodOptions(
        transfer="flip", stress_update="last", stress_filter="auto", mass_scaling=1.0
    )
    assert known_limits.of_method(Scene()) == []


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"grid": Mesh(shape="linear")}, "Linear shapes"),
        ({"grid": Mesh(shape="bspline", points_per_cell=4)}, "Splines ignore"),
        ({"method": Method(stress_filter="smoothing")}, "no projection"),
        ({"method": Method(noise_control="none")}, "ratchets"),
        ({"method": Method(stress_update="first")}, "damps nothing"),
        ({"method": Method(cfl=0.9)}, "cfl is 0.9"),
        ({"method": Method(mass_scaling=100.0)}, "10 times as fast"),
    ],
)
def test_a_choice_with_a_known_weakness_is_told_so(changes, word):
    (sentence,) = known_limits.of_method(Scene(**changes))
    assert word in sentence


def test_sand_with_a_hundred_times_the_inertia_does_the_same_ten_times_slower():
    """The law knows no time: with the same weight, filling ten times as long gives the same stresses."""
    runs = {}
    for factor in (1.0, 100.0):
        method = Method(mass_scaling=factor, filling_time_s=0.3 * factor**0.5, longest_settling_s=0.0)
        simulation = Simulation(Scene(**COARSE, walls=Walls(kind="smooth", friction_angle_deg=19.0), method=method))
        runs[factor] = simulation, list(simulation.fill())[-1]
    (light, one), (heavy, other) = runs.values()
    assert heavy.model.period == pytest.approx(10.0 * light.model.period)
    assert other.time_step_s == pytest.approx(10.0 * one.time_step_s, rel=1e-6)
    assert other.weight_N_per_m == pytest.approx(one.weight_N_per_m, rel=1e-12)
    assert other.normal_N_per_m == pytest.approx(one.normal_N_per_m, rel=1e-6)
    assert abs(other.residual_N_per_m) < 1e-9 * other.weight_N_per_m


def test_a_silo_at_rest_does_not_depend_on_the_shape_but_on_what_the_stress_update_damps():
    """Updated first, or from echoed velocities, the stress keeps noise that the drag alone does not hold."""

    def normal(shape="ugimp", update="last"):
        method = Method(stress_update=update, filling_time_s=0.3, longest_settling_s=0.2)
        scene = Scene(
            silo=COARSE["silo"], grid=Mesh(cell_size_m=0.02, shape=shape), machine=COARSE["machine"],
            walls=Walls(kind="smooth", friction_angle_deg=19.0), method=method,
        )  # fmt: skip
        return list(Simulation(scene).fill())[-1].normal_N_per_m

    usual = normal()
    assert normal(shape="cpdi") == pytest.approx(usual, rel=0.002)
    for update in ("first", "modified"):
        assert 1.03 * usual < normal(update=update) < 1.10 * usual


def test_what_leaves_is_booked_and_what_stays_goes_on():
    particles, _ = block(width=0.1, height=0.1, cell=0.02)
    arrays = particles.arrays()
    arrays["velocity"][:, 1] = -2.0
    particles.load(arrays)
    whole = arrays["mass"].sum()
    gone = Discharge(particles, exit_m=0.041, openings=(Opening("floor", 0.0, 0.1),), spacing_m=0.02)
    kept = gone.take_out()
    left = gone.mass
    assert kept.sum() == 15
    assert particles.active[None] == 15
    assert gone.points == 10
    assert left + particles.arrays()["mass"].sum() == pytest.approx(whole, rel=1e-15)
    assert gone.momentum[1] == pytest.approx(-2.0 * left)
    assert (particles.arrays()["position"][:, 1] > 0.041).all()
    assert gone.take_out() is None


def test_sand_counts_with_what_of_it_has_passed_the_opening():
    """Five columns of five points of 20 mm; the middle three sink by 15 mm, through an opening as wide as these."""
    particles, _ = block(width=0.1, height=0.1, cell=0.02)
    each, place = particles.arrays()["mass"][0], particles.arrays()["position"]
    inner = np.abs(place[:, :1] - 0.05) < 0.03
    change(particles, position=place - inner * [0.0, 0.015])
    gone = Discharge(particles, exit_m=-0.01, openings=(Opening("floor", 0.04, 0.06),), spacing_m=0.02)
    assert gone.take_out() is None
    assert gone.passing == pytest.approx(3 * 0.75 * each)  # of the columns beside the edges, too
    change(particles, position=place - inner * [0.0, 0.025])
    assert gone.take_out().sum() == 22
    assert gone.mass == pytest.approx(3 * each)
    assert gone.passing == pytest.approx(3 * 0.25 * each)
    assert gone.flows(each) and not gone.flows(each), "nothing has passed since"
    place = particles.arrays()["position"]
    place[0] = 0.015, -0.003  # below the floor, beside the opening
    change(particles, position=place)
    assert not gone.take_out()[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_runs_through_a_whole_coarse_silo(shape):
    """Filled and lowered: balance closed, all sand there, N within 5 % of Janssen's neighbourhood of uGIMP's."""
    scene = Scene(
        silo=COARSE["silo"], grid=Mesh(cell_size_m=0.02, shape=shape), machine=COARSE["machine"],
        walls=Walls(kind="smooth", friction_angle_deg=19.0), flow=Flow(speed_m_per_s=0.02, displacement_m=0.001),
        method=Method(filling_time_s=0.2, longest_settling_s=0.1),
    )  # fmt: skip
    records = list(Simulation(scene).run())
    assert max(abs(r.residual_N_per_m) for r in records) < 1e-9 * scene.weight_N_per_m
    assert max(r.strays for r in records) == 0
    assert np.isfinite([r.normal_N_per_m for r in records]).all()


@pytest.mark.parametrize(
    ("cell_size_m", "cores", "threads"), [(0.005, 8, 4), (0.005, 2, 2), (0.01, 8, 1), (0.0025, 64, 16)]
)
def test_a_scene_takes_a_thread_for_a_thousand_points(monkeypatch, cell_size_m, cores, threads):
    monkeypatch.setattr("taichi_silo.scene.scene.cores", lambda: cores)
    assert Scene(grid=Mesh(cell_size_m=cell_size_m)).machine.threads == threads
    assert Scene(grid=Mesh(cell_size_m=cell_size_m), machine=Machine(threads=1)).machine.threads == 1
