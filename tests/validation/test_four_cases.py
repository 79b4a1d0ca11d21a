"""The paper's four mass flows as they are published: `make test-long` (about a quarter of an hour).

TAICHI_SILO_FOUR_CASES=outputs/four_cases judges runs that are there already.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

pytestmark = pytest.mark.long

SCRIPT = Path(__file__).parents[2] / "validation" / "four_cases.py"
NAMES = ("dense_smooth", "dense_very-rough", "loose_smooth", "loose_very-rough")


class Case:
    """One run folder."""

    def __init__(self, folder: Path):
        self.summary = json.loads((folder / "summary.json").read_text())
        self.forces = pd.read_csv(folder / "forces.csv")
        self.flow = self.forces[self.forces.stage == "flow"]
        self.certificate = self.summary["certificate"]
        self.weight = self.summary["weight_N_per_m"]

    def at(self, displacement_m: float, column: str) -> float:
        near = (self.flow.displacement_m - displacement_m).abs() < 1e-4
        return float(self.flow[near][column].mean())


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    folder = os.environ.get("TAICHI_SILO_FOUR_CASES")
    if folder is None:
        folder = tmp_path_factory.mktemp("four") / "cases"
        subprocess.run([sys.executable, str(SCRIPT), "--output", str(folder), "--no-film"], check=True)
    return {name: Case(Path(folder) / name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_the_balance_closes_and_the_noise_is_small(cases, name):
    certificate = cases[name].certificate
    assert certificate["force_balance_residual_over_weight"] < 1e-9
    assert certificate["noise_of_normal_force"] < 0.01
    assert certificate["largest_noise_control_force_over_weight"] < 0.003
    assert certificate["kinetic_energy_over_rigid_motion"][1] < 5.0
    assert certificate["inertial_number_99th_percentile"] < 1e-3
    assert certificate["largest_time_step_over_stable"] < 1.2


@pytest.mark.parametrize("name", ["dense_smooth", "loose_smooth"])
def test_no_ratcheting_between_smooth_walls(cases, name):
    case = cases[name]
    assert abs(case.certificate["mean_void_ratio_drift"]) < 0.003
    assert case.certificate["core_strain_path"] < 5e-4
    low, high = case.certificate["kinetic_energy_over_rigid_motion"]
    assert low > 0.9 and high < 1.1
    filled = case.summary["filling"]["normal_N_per_m"]
    later = case.flow[case.flow.displacement_m > 5e-4]
    normal = 0.5 * (later.left_normal_N_per_m + later.right_normal_N_per_m)
    assert (normal / filled - 1.0).abs().max() < 0.04


@pytest.mark.parametrize(("name", "angle"), [("dense_smooth", 19.0), ("loose_smooth", 12.3)])
def test_smooth_walls_slide_at_their_friction_angle(cases, name, angle):
    assert cases[name].at(0.01, "wall_friction_angle_deg") == pytest.approx(angle, abs=0.01)


@pytest.mark.parametrize("name", ["dense_smooth", "loose_smooth"])
def test_filling_agrees_with_janssen(cases, name):
    janssen = cases[name].summary["janssen"]
    for ratio in ("K0", "measured"):
        for force in ("normal", "shear", "bottom"):
            assert abs(janssen[f"{force}_N_per_m_{ratio}_relative_difference"]) < 0.15


@pytest.mark.parametrize("name", ["dense_very-rough", "loose_very-rough"])
def test_filling_between_very_rough_walls_lies_between_janssen_at_the_two_pressure_ratios(cases, name):
    """With the wall friction that is mobilised."""
    janssen, filled = cases[name].summary["janssen"], cases[name].summary["filling"]
    for force in ("normal", "shear", "bottom"):
        ends = sorted(janssen[f"{force}_N_per_m_{ratio}"] for ratio in ("K0", "measured"))
        assert 0.85 * ends[0] < filled[f"{force}_N_per_m"] < 1.15 * ends[1]
    ends = sorted(janssen[f"pressure_ratio_{ratio}"] for ratio in ("K0", "measured"))
    assert 0.85 * ends[0] < janssen["pressure_ratio_fitted"] < 1.15 * ends[1]


def test_dense_sand_between_very_rough_walls(cases):
    case = cases["dense_very-rough"]
    filled, peak = case.summary["filling"], case.summary["peak"]
    assert peak["min_bottom_N_per_m"]["value"] < 0.5 * filled["bottom_N_per_m"]
    assert peak["min_bottom_N_per_m"]["displacement_m"] < 1e-3
    assert case.at(0.02, "bottom_force_N_per_m") > 1.3 * peak["min_bottom_N_per_m"]["value"]
    assert peak["max_shear_N_per_m"]["displacement_m"] < 1e-3
    assert case.summary["residual"]["shear_N_per_m"] < 0.95 * peak["max_shear_N_per_m"]["value"]
    assert case.summary["residual"]["normal_N_per_m"] > 1.5 * filled["normal_N_per_m"]
    assert 43.0 < peak["max_wall_friction_angle_deg"]["value"] < 47.5
    assert 30.0 < case.summary["residual"]["wall_friction_angle_deg"] < 36.0
    zones = case.summary["shear_zones"]
    assert not zones["left"]["contractant"] and zones["left"]["thickness_m"] > 0.004
    assert zones["interior_zones"]["count"] >= 2


def test_loose_sand_between_very_rough_walls_contracts_along_them(cases):
    zones = cases["loose_very-rough"].summary["shear_zones"]
    for side in ("left", "right"):
        assert zones[side]["contractant"]
        assert zones[side]["thickness_m"] > 0.004


def test_without_friction_left_and_right_stay_equal_to_round_off():
    from taichi_silo import Flow, Scene, Silo, Simulation, Walls
    from taichi_silo.mpm import runtime

    runtime.init()
    simulation = Simulation(
        Scene(
            silo=Silo(half="no"), walls=Walls(kind="smooth", friction_angle_deg=0.0),
            flow=Flow(speed_m_per_s=0.005, displacement_m=0.003),
        )
    )  # fmt: skip
    weight = simulation.scene.weight_N_per_m
    for record in simulation.run():
        assert abs(record.left_normal_N_per_m - record.right_normal_N_per_m) < 1e-12 * weight
