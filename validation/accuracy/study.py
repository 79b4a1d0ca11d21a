"""The runs of the chart: of each scene those that tell its truth, and one for each setting of each dial."""

import hashlib
import json
import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from taichi_silo.analysis.extrapolation import limit
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import parameters
from taichi_silo.scene.scene import Scene
from taichi_silo.studies.converge.estimate import CARRIED
from taichi_silo.studies.converge.quantities import Quantity, quantities
from taichi_silo.studies.sweep.runs import Run
from validation.accuracy import dials, scenes, table
from validation.accuracy.table import Truth

COLUMNS = {"P": "bottom_force_N_per_m", "T": "left_shear_N_per_m", "N": "left_normal_N_per_m"}
PACE_S = 55e-9  # of an idle core, for a point and step of the base


@dataclass(frozen=True)
class Row:
    """One row of the chart: scene, dial and setting in words, and the run, which several rows may share."""

    scene: str
    dial: str
    setting: str
    run: Run


def planned(names: list[str], wanted: list[str], folder: Path, full: bool = False) -> list[Row]:
    """All rows of some scenes and dials, and those that the truth needs.

    Rows of one scene whose values are the same share a run. `full` is as of `dials.turned`.
    """
    rows: list[Row] = []
    for name in names:
        runs: dict[str, Run] = {}
        for dial in dict.fromkeys((*wanted, dials.FINE, dials.SLOW)):
            for setting in dials.turned(dial, name, full):
                words, one = dials.words(setting), scenes.scene(name, dials.settings(setting, scenes.scene(name, {})))
                called = re.sub(r"[^a-z0-9.]+", "-", f"{dial} {words}".lower())
                run = runs.setdefault(_key(one), Run(one, folder / name.replace(" ", "_") / called))
                rows.append(Row(name, dial, words, run))
    return rows


def _key(scene: Scene) -> str:
    return hashlib.sha256(json.dumps(parameters(scene), sort_keys=True, default=str).encode()).hexdigest()


def numbers(run: Run) -> dict[str, Quantity]:
    """The numbers of a run; between very rough walls P, T and N in flow are those half way, over a twentieth of it."""
    result = Result(run.folder)
    found = quantities(result)
    if run.scene.walls.kind == "very-rough":
        for force in COLUMNS:
            found[f"{force}_residual"] = replace(found[f"{force}_residual"], value=half_way(result, force))
    return found


def half_way(run: Result, force: str) -> float:
    """Mean of P, T or N [N/m] about half of the displacement, over a twentieth of it."""
    flow, last = run.forces[run.forces.stage == "flow"], run.scene.flow.displacement_m
    return float(flow.loc[(flow.displacement_m - 0.5 * last).abs() < 0.025 * last, COLUMNS[force]].mean())


def truth(rows: list[Row], scene: str) -> dict[str, Truth]:
    """The numbers of a scene without cells, whose bottom sinks at the default speed, with error bars.

    They are extrapolated from the runs on fine cells, and moved by what the speed changes on the cells of the base.
    """
    cells, speeds = (
        [row.run for row in rows if row.scene == scene and row.dial == dial] for dial in (dials.FINE, dials.SLOW)
    )
    fine, slow = ([numbers(run) for run in some] for some in (cells, speeds))
    found = {}
    for name, last in fine[-1].items():
        if all(name in one for one in (*fine, *slow)):
            grid = limit([run.scene.grid.cell_size_m for run in cells], [one[name].value for one in fine])
            by_speed = dict(zip(dials.SPEEDS, [one[name].value for one in slow], strict=True))
            slower = by_speed[scenes.SLOW] - by_speed[scenes.BASE[scenes.SPEED]]
            error = math.hypot(grid.error, CARRIED * slower)
            found[name] = Truth(grid.value + slower, error, last.unit, last.scale)
    return found


def rows(wanted: list[Row], truths: dict[str, dict[str, Truth]]) -> pd.DataFrame:
    """The chart: scene, dial, setting, run, cost, errors, whether it is on the front, and why a run failed.

    The cost is steps times points at one pace, however busy the machine was; what parts of the method cost a step is in
    `docs/data/parts.csv`.
    """
    found, kept = [], {}
    for row in wanted:
        folder = row.run.folder
        summary = row.run.summary
        line: dict[str, object] = {"scene": row.scene, "dial": row.dial, "setting": row.setting, "run": folder.name}
        cost = summary.get("cost", {})
        line["core_seconds"] = PACE_S * cost.get("points", math.nan) * cost.get("steps", math.nan)
        if row.run.finished and folder not in kept:
            kept[folder] = table.errors(numbers(row.run), truths[row.scene])
        line |= kept.get(folder, {})
        line["failure"] = "" if row.run.finished else summary.get("failure") or "not run"
        found.append(line)
    return table.with_front(pd.DataFrame(found))


def known(truths: dict[str, dict[str, Truth]]) -> pd.DataFrame:
    """What the errors are told against: each number of each scene with its error bar."""
    return pd.DataFrame(
        {"scene": name, "quantity": quantity, "value": one.value, "error": one.error, "unit": one.unit,
         "relative_error": one.relative_error}
        for name, numbers in truths.items() for quantity, one in numbers.items()
    )  # fmt: skip


def of_fidelities(rows: pd.DataFrame, truths: dict[str, dict[str, Truth]]) -> dict[str, dict[str, dict[str, float]]]:
    """Of each scene and named setting the errors of P, T and N at the end, and the bar of the truth."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for row in rows[(rows["dial"] == dials.NAMED) & rows[table.WORST].notna()].to_dict("records"):
        known_to = table.bars(truths[row["scene"]])[table.WORST]
        told = {force: row[force] for force in "PTN"} | {"known_to": known_to}
        found.setdefault(row["scene"], {})[row["setting"]] = {name: float(f"{one:.2g}") for name, one in told.items()}
    return found


def of_changes(rows: list[Row]) -> dict[str, dict[str, float]]:
    """Of each scene by how much of the weight a part of the method changes P, T or N at the end, at most."""
    found: dict[str, dict[str, float]] = {}
    for scene in dict.fromkeys(row.scene for row in rows):
        runs = {(row.dial, row.setting): row.run for row in rows if row.scene == scene}
        for part, (one, other) in dials.CHANGES.items():
            if one in runs and other in runs:
                first, second = (numbers(runs[which]) for which in (one, other))
                change = max(abs(first[name].value - second[name].value) / first[name].scale for name in table.FORCES)
                found.setdefault(scene, {})[part] = float(f"{change:.2g}")
    return found
