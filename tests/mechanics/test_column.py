"""A column of sand whose wall is taken away: mass, forces and energy in balance, at rest in the end."""

import numpy as np
import pytest

from taichi_silo import Scene, run

pytestmark = pytest.mark.usefixtures("afresh")


def collapsed(folder, aspect: float, **silo):
    """A coarse run: 8 cells across L0."""
    cell = 0.0125
    high = round(8 * aspect) * cell
    scene = Scene.model_validate(
        {
            "silo": {"width_m": 0.5, "height_m": high, "column_m": [0.0, 0.1]} | silo,
            "sand": {"void_ratio": 0.8},
            "walls": {"kind": "smooth", "friction_angle_deg": 0.0, "bottom_friction_angle_deg": 30.0},
            "grid": {"cell_size_m": cell, "points_per_cell": 4},
            "flow": {"outflow": "collapse"},
            "method": {"filling_time_s": 0.01, "longest_settling_s": 0.0},
            "output": {"snapshots": 20, "records_per_period": 4},
            "machine": {"threads": 1},
        }
    )
    return run(scene, folder, film=False, figures=False, progress=False)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    return {aspect: collapsed(tmp_path_factory.mktemp("column") / "run", aspect) for aspect in (0.5, 1.5)}


def test_the_wall_bears_the_sand_until_it_is_gone(runs):
    """A frictionless wall: N = K gamma H^2 / 2, both walls alike; without it the right side bears nothing."""
    run = runs[1.5]
    filled = run.filled
    weight = run.scene.weight_N_per_m
    assert filled["right_normal_N_per_m"] == pytest.approx(filled["left_normal_N_per_m"], rel=0.02)
    k = 2.0 * filled["right_normal_N_per_m"] / (weight / 0.1 * 0.15)
    assert 0.3 < k < 0.7
    assert filled["P"] == pytest.approx(weight, rel=0.02)
    assert run.flow["right_normal_N_per_m"].abs().max() < 1e-6 * weight  # round-off
    assert run.flow["left_normal_N_per_m"].iloc[-1] > 0.0


@pytest.mark.parametrize("aspect", [0.5, 1.5])
def test_mass_is_kept_forces_balance_and_the_sand_rests_in_the_end(runs, aspect):
    run = runs[aspect]
    found, history = run.summary["collapse"], np.genfromtxt(run.folder / "collapse.csv", delimiter=",", names=True)
    assert not run.summary.get("alarms")
    assert history["mass_kg_per_m"] == pytest.approx(np.full(len(history), history["mass_kg_per_m"][0]), rel=1e-9)
    assert run.balance["residual_N_per_m"].abs().max() < 1e-6 * run.scene.weight_N_per_m
    assert found["kinetic_energy_over_first_potential"] < 1e-4
    assert run.flow["P"].iloc[-1] == pytest.approx(run.scene.weight_N_per_m, rel=0.02)
    assert 10.0 < found["slope_deg"] < 35.0  # no steeper than the angle of repose of the sand


@pytest.mark.parametrize("aspect", [0.5, 1.5])
def test_the_sand_gains_no_energy(runs, aspect):
    """Potential and kinetic energy fall from state to state: friction takes some of what the fall gives."""
    history = np.genfromtxt(runs[aspect].folder / "collapse.csv", delimiter=",", names=True)
    energy = history["potential_energy_J_per_m"] + history["kinetic_energy_J_per_m"]
    assert (np.diff(energy) < 2e-3 * energy[0]).all()
    assert history["potential_energy_J_per_m"][-1] < 0.95 * energy[0]


def test_a_higher_column_runs_out_farther(runs):
    """In the first regime the run-out over L0 goes with the aspect ratio."""
    low, high = (runs[aspect].summary["collapse"]["run_out_over_L0"] for aspect in (0.5, 1.5))
    assert high > 2.0 * low > 0.4
    assert runs[0.5].summary["collapse"]["height_over_L0"] == pytest.approx(0.5, abs=0.07)  # a < 1.15: the top stays


def test_a_column_in_the_middle_spreads_to_both_sides_alike(tmp_path):
    run = collapsed(tmp_path / "run", 0.5, column_m=[0.15, 0.35], half="yes")
    last = np.genfromtxt(run.folder / "collapse.csv", delimiter=",", names=True)[-1]
    assert last["left_run_out_m"] == pytest.approx(last["right_run_out_m"], abs=1e-9)
    assert last["left_run_out_m"] > 0.01
