"""The tables of the four cases say what the summaries of the runs say."""

import json

from validation.case_tables import write_tables

STATE = {
    "bottom_N_per_m": 1150.4, "shear_N_per_m": 236.6, "normal_N_per_m": 697.0, "wall_friction_angle_deg": 18.75,
}  # fmt: skip
SUMMARY = {
    "filling": STATE, "residual": STATE | {"normal_N_per_m": 699.0},
    "janssen": {"normal_N_per_m_K0": 674.4, "normal_N_per_m_measured": 675.8},
    "largest_wall_normal_stress_Pa": {
        state: {"node": 2742.0, "pressure_cell": 2659.0} for state in ("filling", "residual")
    },
    "certificate": {
        "force_balance_residual_over_weight": 1.4e-15, "noise_of_normal_force": 5.1e-6,
        "noise_control_force_over_weight_99th_percentile": 1.5e-6, "largest_noise_control_force_over_weight": 6.5e-5,
        "kinetic_energy_over_rigid_motion": [0.9965, 1.0068], "largest_kinetic_energy_over_work": 3.6e-3,
        "inertial_number_99th_percentile": 1.6e-9, "mean_void_ratio_drift": -5.2e-6, "core_strain_path": 8.9e-6,
        "unexplained_densification": 5.2e-6,
    },
    "shear_zones": {side: {"thickness_m": None, "contractant": False} for side in ("left", "right")},
}  # fmt: skip


def test_forces_are_in_kilonewtons_and_each_measure_has_its_line(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "summary.json").write_text(json.dumps(SUMMARY))
    forces, certificate = (file.read_text() for file in write_tables({"dense": tmp_path / "run"}, tmp_path))
    assert "dense,filled,1.150,0.237,0.697,18.8°,0.674 / 0.676,2.7 / 2.7 kPa" in forces
    assert 'dense,"residual, u = 19–20 mm",1.150,0.237,0.699,18.8°,,2.7 / 2.7 kPa' in forces
    assert "mean void ratio: change in flow,-5.2e-06,±0.003 smooth" in certificate
    assert '"wall zone (left, right)",0.0 0.0 mm,' in certificate
