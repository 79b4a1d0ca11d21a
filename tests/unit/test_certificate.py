"""The certificate measures what it says, on histories whose noise, drift and flow are known."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.runs.certificate import certificate, noise
from taichi_silo.scene.scene import Flow, Scene
from taichi_silo.simulation.clock import Clock

PERIOD, INTERVAL = 0.02, 0.002
SCENE = Scene(flow=Flow(speed_m_per_s=0.002, displacement_m=0.002))


def history(wobble=0.0, drift=0.0, rows=500):
    """Flow records of a wall force that oscillates with the column's period and drifts."""
    time = (np.arange(rows) + 1) * INTERVAL
    normal = 700.0 * (1.0 + wobble * np.sin(2 * np.pi * time / PERIOD) + drift * time)
    zero = 0.0 * time
    return pd.DataFrame(
        {
            "time_s": time, "stage": "flow", "interval_s": INTERVAL, "displacement_m": 0.002 * time,
            "normal_N_per_m": normal, "left_normal_N_per_m": normal + 0.5, "right_normal_N_per_m": normal - 0.5,
            "noise_control_force_N_per_m": zero + 3.0, "residual_N_per_m": zero + 1e-9, "time_step_s": zero + 1e-5,
            "stable_step_s": zero + 2e-5, "kinetic_energy_J_per_m": zero + 1e-4,
        }
    )  # fmt: skip


def state(time_s, settle=0.0, path=0.0):
    """A lattice of points, settled uniformly by a strain."""
    x, y = np.meshgrid((np.arange(40) + 0.5) * 0.005, (np.arange(100) + 0.5) * 0.005)
    count = x.size
    return {
        "position": np.stack([x.ravel(), y.ravel() * (1.0 - settle)], axis=1),
        "void_ratio": np.full(count, 1.6 * (1.0 - settle) - 1.0),
        "mass": np.full(count, 0.04),
        "path": np.full(count, path),
        "stress": np.tile([-2e3, -4e3, -2e3, 0.0], (count, 1)),
        "time_s": time_s,
    }


def judge(records, final, filled=None):
    section = SimpleNamespace(points_per_computed=1)
    model = SimpleNamespace(period=PERIOD, mass=165.6, section=section, control=NoiseControl())
    simulation = SimpleNamespace(scene=SCENE, model=model, clock=Clock(settled=True, flow_start=0.0))
    return certificate(records, filled or state(0.0), final, simulation)


def test_noise_is_the_rms_of_an_oscillation_and_no_drift():
    shaken, drifting = history(wobble=0.01), history(drift=0.05)
    assert noise(shaken.normal_N_per_m, shaken.interval_s, 3 * PERIOD) == pytest.approx(0.01 / np.sqrt(2), rel=0.05)
    assert noise(drifting.normal_N_per_m, drifting.interval_s, 3 * PERIOD) < 1e-4


def test_without_vertical_walls_there_is_no_normal_force_whose_noise_could_be_told():
    found = judge(history().assign(normal_N_per_m=0.0), state(1.0))
    assert "noise_of_normal_force" not in found
    assert found["largest_noise_control_force_over_weight"] > 0.0


def test_ratcheting_is_densification_that_shear_does_not_explain():
    found = judge(history(), state(1.0, settle=0.03, path=0.1))
    assert found["unsheared_share"] == 1.0
    assert found["unexplained_densification"] == pytest.approx(0.048, rel=1e-6)
    assert found["mean_void_ratio_drift"] == pytest.approx(-0.048, rel=1e-6)
    assert found["core_strain_path"] == pytest.approx(0.1)


def test_ratios_are_taken_to_weight_work_and_rigid_motion():
    found, weight = judge(history(), state(1.0)), SCENE.weight_N_per_m
    assert found["left_right_difference_over_weight"] == pytest.approx(1.0 / weight)
    assert found["largest_noise_control_force_over_weight"] == pytest.approx(3.0 / weight)
    assert found["kinetic_energy_over_rigid_motion"][1] == pytest.approx(1e-4 / (0.5 * 165.6 * 0.002**2))
    assert found["largest_kinetic_energy_over_work"] == pytest.approx(1e-4 / (weight * 0.002 * INTERVAL))
    assert found["largest_time_step_over_stable"] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("above", "onset"),
    [(slice(0, 3), None), (slice(10, None), 10), (slice(0, None), 0), (slice(2, 2), None)],
    ids=["begins with a flicker", "grows", "from the first row", "never"],
)
def test_the_walls_differ_from_where_on_the_difference_stays(above, onset):
    rows = history()
    apart = np.zeros(len(rows))
    apart[above] = 1e-7 * SCENE.weight_N_per_m
    found = judge(rows.assign(left_normal_N_per_m=100.0 + apart, right_normal_N_per_m=100.0), state(1.0))
    place = found.get("left_right_difference_from_displacement_m")
    assert place == (None if onset is None else rows.displacement_m.iloc[onset])


def test_a_difference_that_was_there_before_the_flow_begins_at_0():
    rows = history()
    filling = rows.assign(stage="filling", displacement_m=0.0)
    both = pd.concat([filling, rows], ignore_index=True)
    found = judge(both.assign(left_normal_N_per_m=101.0, right_normal_N_per_m=100.0), state(1.0))
    assert found["left_right_difference_from_displacement_m"] == 0.0


def test_inertial_number_is_rate_times_grain_size_over_the_speed_of_stress():
    found = judge(history(), state(1.0, path=0.02))
    exact = np.sqrt(2) * 0.02 * 0.5e-3 * np.sqrt(2650.0 / (8e3 / 3))
    assert found["inertial_number_99th_percentile"] == pytest.approx(exact)


def test_a_flow_that_ends_in_its_start_has_no_steady_measures():
    found = judge(history(rows=20), state(0.04))
    assert "noise_of_normal_force" not in found
    assert "mean_void_ratio_drift" in found


def test_a_silo_that_has_emptied_but_for_its_corners_has_a_certificate():
    corner = state(0.0)["position"][:, 0] < 0.03
    filled, final = (
        {name: values[corner] if isinstance(values, np.ndarray) else values for name, values in state(time).items()}
        for time in (0.0, 1.0)
    )
    assert "core_strain_path" not in judge(history(), final, filled)
