"""Tables of several runs side by side: forces and theory, and what certifies each run."""

import json
from pathlib import Path

import pandas as pd

STATES = {"filling": "filled", "residual": "residual, u = 19–20 mm"}


def write_tables(folders: dict[str, Path], target: Path) -> list[Path]:
    """Leave `four_cases.csv` and `certificate.csv`; `folders` are the runs' by their names."""
    summaries = {
        name: json.loads((folder / "summary.json").read_text(encoding="utf-8")) for name, folder in folders.items()
    }
    target.mkdir(parents=True, exist_ok=True)
    tables = {"four_cases": forces(summaries), "certificate": certificates(summaries)}
    for name, table in tables.items():
        table.to_csv(target / f"{name}.csv", index=False)
    return [target / f"{name}.csv" for name in tables]


def forces(summaries: dict[str, dict]) -> pd.DataFrame:
    """P, T, N [kN/m], their angle, N of Janssen's theory with the law's K0 and the sand's own K, largest wall stresses.

    The largest wall stress is that of a node and that of a pressure cell [kPa].
    """
    rows = []
    for name, found in summaries.items():
        for state, words in STATES.items():
            force, theory = found[state], found["janssen"]
            in_theory = " / ".join(f"{theory[f'normal_N_per_m_{key}'] / 1e3:.3f}" for key in ("K0", "measured"))
            largest = found["largest_wall_normal_stress_Pa"][state]
            rows.append(
                {
                    "case": name,
                    "state": words,
                    **{
                        short: f"{force[f'{long}_N_per_m'] / 1e3:.3f}"
                        for short, long in (("P", "bottom"), ("T", "shear"), ("N", "normal"))
                    },
                    "angle": f"{force['wall_friction_angle_deg']:.1f}°",
                    "janssen_N": in_theory if state == "filling" else "",
                    "largest": f"{largest['node'] / 1e3:.1f} / {largest['pressure_cell'] / 1e3:.1f} kPa",
                }
            )  # fmt: skip
    return pd.DataFrame(rows)


def certificates(summaries: dict[str, dict]) -> pd.DataFrame:
    """One row a measure of the certificate, one column a case, and what is good."""

    def zone(found):
        sides = [found["shear_zones"][side] for side in ("left", "right")]
        widths = " ".join(f"{1e3 * (side['thickness_m'] or 0.0):.1f}" for side in sides)
        return widths + (" mm contractant" if sides[0]["contractant"] else " mm")

    measures = {
        "balance residual / W, largest of all rows": ("{force_balance_residual_over_weight:.1e}", "1e-9"),
        "noise of N: RMS about its moving mean / N": ("{noise_of_normal_force:.1e}", "0.01"),
        "noise-control force / W: 99th percentile, largest": (
            "{noise_control_force_over_weight_99th_percentile:.1e}, {largest_noise_control_force_over_weight:.1e}",
            "largest 0.003",
        ),
        "kinetic energy / rigid motion, least and largest": (
            "{kinetic_energy_over_rigid_motion[0]:.4g}, {kinetic_energy_over_rigid_motion[1]:.4g}",
            "0.9 to 1.1 smooth, at most 5 very rough",
        ),
        "largest kinetic energy / work": ("{largest_kinetic_energy_over_work:.1e}", ""),
        "inertial number, 99th percentile": ("{inertial_number_99th_percentile:.1e}", "1e-3"),
        "mean void ratio: change in flow": ("{mean_void_ratio_drift:+.1e}", "±0.003 smooth"),
        "path length of the strain in the core": ("{core_strain_path:.1e}", "5e-4 smooth"),
        "densification that shear does not explain": ("{unexplained_densification:+.1e}", "0.003"),
    }
    rows = [
        {"measure": words}
        | {name: pattern.format(**found["certificate"]) for name, found in summaries.items()}
        | {"good below": good}
        for words, (pattern, good) in measures.items()
    ]
    zones = {name: zone(found) for name, found in summaries.items()}
    return pd.DataFrame([*rows, {"measure": "wall zone (left, right)", **zones, "good below": ""}])
