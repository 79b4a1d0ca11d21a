"""The chart as a table: one row a setting, with what it costs and how wrong it is."""

import math

import pandas as pd

from taichi_silo.scene.dotted_paths import OUTSIDE, value
from validation.accuracy.errors import ERRORS, errors, pareto_front, scatter
from validation.accuracy.plan import REFERENCE, ChartRow

CERTIFICATE = (
    "inertial_number_99th_percentile",
    "noise_of_normal_force",
    "largest_kinetic_energy_over_work",
    "mean_void_ratio_drift",
    "core_strain_path",
    "unexplained_densification",
    "force_balance_residual_over_weight",
    "noise_control_force_over_weight_99th_percentile",
    "settled_before_flow",
)
COST = ("points", "steps", "time_step_s", "predicted_steps", "predicted_core_seconds")


def chart(planned: list[ChartRow], found: dict[str, dict], paths: list[str]) -> pd.DataFrame:
    """Rows of `chart.csv`.

    Parameters
    ----------
    planned : all rows; those without numbers are left out.
    found : what `parameter_set.simulate` returned, by the key of the parameter set.
    paths : dotted paths of all varied settings, whose values become columns.

    Returns
    -------
    walls, dial, setting, purpose; one column a path; cost_core_seconds and what makes it up; errors; on_front (of
    error_N against cost, among one pair of walls); residual forces [N/m]; the quasi-static certificate; the reference's
    settings in words, and the failure, if there is one. The column `dial` names what is varied.

    """
    reference = {e.walls: (found.get(e.parameters.key), e.setting) for e in planned if e.varied == REFERENCE}
    rows = []
    for entry in planned:
        run = found.get(entry.parameters.key)
        truth, name = reference[entry.walls]
        if run is None:
            continue
        row = {"walls": entry.walls, "dial": entry.varied, "setting": entry.setting, "purpose": entry.purpose}
        for path in paths:
            row[path] = value(entry.parameters if path in OUTSIDE else entry.parameters.scene, path)
        cost = run["cost"]
        row |= {"cost_core_seconds": cost["core_seconds"]} | {name: cost[name] for name in COST}
        row["nanoseconds_per_particle_step"] = 1e9 * cost["core_seconds"] / max(cost["points"] * cost["steps"], 1)
        row |= errors(run, truth) if truth else dict.fromkeys(ERRORS, math.nan)
        row |= {f"residual_{force}_N_per_m": run.get("residual", {}).get(force, math.nan) for force in "PTN"}
        row |= {measure: run.get("certificate", {}).get(measure, math.nan) for measure in CERTIFICATE}
        row |= {"reference": name, "failure": run["failure"] or "", "key": entry.parameters.key}
        rows.append(row)
    table = pd.DataFrame(rows)
    on_front = pd.Series(False, index=table.index)
    for _, some in table[~table.key.isin(table.key[table.dial == REFERENCE])].groupby("walls"):
        once = some.drop_duplicates("key")
        best = once.key[pareto_front(once.cost_core_seconds, once.error_N)]
        on_front[some.index] = some.key.isin(best)
    table.insert(table.columns.get_loc("error_zone") + 1, "on_front", on_front)
    return table


def floors(planned: list[ChartRow], found: dict[str, dict]) -> pd.DataFrame:
    """Rows of `scatter.csv`: for each pair of walls the errors between runs that differ by rounding only."""
    rows = []
    for walls in dict.fromkeys(entry.walls for entry in planned):
        keys = dict.fromkeys(e.parameters.key for e in planned if e.walls == walls and e.varied == "rounding")
        rows.append({"walls": walls} | scatter([found[key] for key in keys if key in found]))
    return pd.DataFrame(rows)
