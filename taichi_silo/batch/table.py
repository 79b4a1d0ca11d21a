"""A batch as a table: one row a run, with what was varied and what was found."""

from pathlib import Path

import pandas as pd

from taichi_silo.batch.runs import Run
from taichi_silo.batch.variations import used

FORCES = {"P": ("bottom_N_per_m", "least", "min"), "T": ("shear_N_per_m", "largest", "max"),
          "N": ("normal_N_per_m", "largest", "max")}  # fmt: skip
ANGLE = "wall_friction_angle_deg"


def row(name: str, run: Run, paths: list[str], failure: str = "") -> dict:
    """Of one run.

    Parameters
    ----------
    name : of the run.
    run : its scene and folder.
    paths : dotted paths whose values become columns.
    failure : why it left nothing, if that is known.

    Returns
    -------
    run; one column a path; P, T, N after filling, their extreme in flow and their residual [N/m]; wall friction angle
    [deg] at the same times; largest wall normal stress of all states away from the corner, at a node and as a pressure
    cell reads it [Pa]; points, steps and seconds of one core; warnings (number); finished; failure.

    """
    found = run.summary
    filling, peak, residual = (found.get(key, {}) for key in ("filling", "peak", "residual"))
    cells = {"run": name} | {path: used(run.scene, path) for path in paths}
    for force, (key, words, extreme) in FORCES.items():
        cells[f"{force}_filled_N_per_m"] = filling.get(key)
        cells[f"{force}_{words}_N_per_m"] = peak.get(f"{extreme}_{key}", {}).get("value")
        cells[f"{force}_residual_N_per_m"] = residual.get(key)
    cells[f"filled_{ANGLE}"] = filling.get(ANGLE)
    cells[f"largest_{ANGLE}"] = peak.get(f"max_{ANGLE}", {}).get("value")
    cells[f"residual_{ANGLE}"] = residual.get(ANGLE)
    stresses = found.get("largest_wall_normal_stress_Pa", {}).values()
    for kind in ("node", "pressure_cell"):
        known = [state[kind] for state in stresses if state.get(kind) is not None]
        cells[f"largest_wall_normal_stress_{kind}_Pa"] = max(known, default=None)
    cost = found.get("cost", {})
    cells |= {"points": run.scene.points, "steps": cost.get("steps"), "core_seconds": cost.get("seconds")}
    finished = found.get("finished", False) and not failure
    cells |= {"warnings": len(found.get("warnings", [])), "finished": finished}
    return cells | {"failure": "" if finished else failure or found.get("failure", "")}


def leave(file: Path, runs: dict[str, Run], paths: list[str], failures: dict[str, str]) -> pd.DataFrame:
    """Write the table of all runs, in one piece or not at all, and return it."""
    table = pd.DataFrame([row(name, run, paths, failures.get(name, "")) for name, run in runs.items()])
    temporary = file.with_name(file.name + ".part")
    table.to_csv(temporary, index=False, float_format="%.6g")
    temporary.replace(file)
    return table
