"""The very rough model silo with the sand's own length resolved: what its numbers are, and what they tend to.

The paper's mass flows of dense and of loose sand, whose bottom sinks by 20 mm, with l_c = 3 d50 = 1.5 mm on cells of
2.5, 2 and 1.54 mm; beside them the paper's own cells of 5 mm, on which the law is local, and, with dense sand on cells
of 2.5 mm, walls that are left out of the non-local mean. Half of the silo is computed, the bottom sinks at 8 mm/s, the
mean goes by a grid.

Leaves the runs (`cells-130/dense_very-rough_bottom`, ...; films of those on the finest cells), `resolved_runs.csv` (a
row a run), `resolved_limits.csv` (what the three grids tend to, with error bars), `resolved_statements.csv` (the
statements of the paper on both grids), and figures. Cost: two hours of one core, 23 minutes of it for the finest cells
of dense sand, 33 for those of loose sand; what has ended is kept.
"""

import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.analysis.extrapolation import limit
from taichi_silo.cli import command_line
from taichi_silo.runs.result import Result
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Scene
from taichi_silo.show.figures.style import STYLE, new_figure
from taichi_silo.studies.converge.quantities import quantities
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation.accuracy.scenes import DENSITIES  # noqa: E402
from validation.accuracy.study import COLUMNS, half_way  # noqa: E402
from validation.paper.check import evaluate  # noqa: E402

BASE = {
    "silo.half": "yes", "flow.speed_m_per_s": 0.008, "flow.displacement_m": 0.02,
    "averaging.characteristic_length_m": 0.0015, "machine.threads": 1,
}  # fmt: skip
SANDS = ("dense", "loose")
PAPERS, RESOLVED = 40, (80, 100, 130)  # cells across
FINEST = RESOLVED[-1]
CELL_M = {40: 0.005, 80: 0.0025, 100: 0.002, 130: 0.00153846154}
LEFT_OUT = "walls-left-out"  # of the mean
TOLD = ("P_filled", "T_filled", "N_filled", "pressure_filled_0.5", "P_residual", "T_residual", "N_residual",
        "pressure_residual_0.5", "zone_thickness")  # fmt: skip
MIDDLE = (0.4, 0.6)  # of the height, over which profiles are means


def resolved_silo(
    output: Annotated[Path, Option(help="folder of the runs, the tables and the figures")] = Path("outputs/resolved"),
):
    """Run the silo on all grids and say what its numbers tend to."""
    output = output.expanduser()
    runs = planned(output)
    run_all({" ".join(key): run for key, run in runs.items()}, output)
    results = {key: Result(run.folder) for key, run in runs.items()}
    tables = {"runs": of_runs(results), "limits": of_limits(results), "statements": of_statements(output)}
    for name, table in tables.items():
        table.to_csv(output / f"resolved_{name}.csv", index=False, float_format="%.4g")
        print(output / f"resolved_{name}.csv")
    with rc_context(STYLE):
        draw_forces(results, output / "resolved_forces.png")
        draw_profiles(results, output / "resolved_profiles.png")


def planned(output: Path) -> dict[tuple[str, str], Run]:
    """The runs by sand and by the name of their grid; the folder of each is named as the paper's flow."""
    kinds: list[tuple] = [
        (sand, f"cells-{cells}", CELL_M[cells], {}) for sand in SANDS for cells in (PAPERS, *RESOLVED)
    ]
    found = {}
    for sand, grid, cell, more in (*kinds, ("dense", LEFT_OUT, CELL_M[80], {"averaging.wall": "ignored"})):
        own = {"sand.void_ratio": DENSITIES[sand], "grid.cell_size_m": cell, **more}
        folder = output / grid / f"{sand}_very-rough_bottom"
        found[sand, grid] = Run(changed(Scene(), BASE | own), folder, film=grid == f"cells-{FINEST}")
    return found


def of_runs(results: dict[tuple[str, str], Result]) -> pd.DataFrame:
    """A row a run: forces [kN/m], angle [degrees], wall stress in the middle [kPa], zones [mm], cost [core hours]."""
    rows = []
    for (sand, grid), run in results.items():
        found, summary = quantities(run), run.summary
        row = {"sand": sand, "grid": grid, "cells_mm": 1e3 * run.scene.grid.cell_size_m}
        row |= {f"{force}_half_way": 1e-3 * half_way(run, force) for force in COLUMNS}
        for state in ("filled", "residual"):
            row |= {f"{force}_{state}": 1e-3 * found[f"{force}_{state}"].value for force in "PTN"}
            row[f"angle_{state}"] = float(np.degrees(np.arctan(found[f"TN_{state}"].value)))
            row[f"pressure_{state}"] = 1e-3 * found[f"pressure_{state}_0.5"].value
        row["wall_zone_mm"] = 1e3 * found["zone_thickness"].value if "zone_thickness" in found else np.nan
        row["sheared_from_mm"], row["sheared_to_mm"] = sheared_mm(across(run))
        inside = summary["zones_inside"]["zones"]
        row["zones_inside"] = len(inside)
        row["zone_inside_mm"] = 1e3 * float(np.median([zone["thickness_m"] for zone in inside])) if inside else np.nan
        row["core_hours"] = summary["cost"]["seconds"] / 3600.0
        rows.append(row)
    return pd.DataFrame(rows)


def of_limits(results: dict[tuple[str, str], Result]) -> pd.DataFrame:
    """What the grids tend to: values, limit, error bar, and distance of the finest; over the measure of each.

    Forces also half way, where zones have not softened yet. A zone that not all grids have has no limit.
    """
    rows = []
    for sand in SANDS:
        runs = [results[sand, f"cells-{cells}"] for cells in RESOLVED]
        cells, found = [run.scene.grid.cell_size_m for run in runs], [quantities(run) for run in runs]
        for name in (one for one in TOLD if all(one in numbers for numbers in found)):
            scale = found[-1][name].scale
            values = [one[name].value for one in found]
            rows.append({"sand": sand} | _limit(name, found[-1][name].unit, cells, values, scale))
        weight = runs[-1].summary["weight_N_per_m"]
        for force in COLUMNS:
            values = [half_way(run, force) for run in runs]
            rows.append({"sand": sand} | _limit(f"{force}_half_way", "N/m", cells, values, weight))
    return pd.DataFrame(rows)


def _limit(name: str, unit: str, cells: list[float], values: list[float], scale: float) -> dict:
    tends = limit(cells, values)
    scale = scale if np.isfinite(scale) else values[-1]
    row: dict = {"quantity": name, "unit": unit} | dict(zip(("coarse", "middle", "fine"), values, strict=True))
    row |= {"limit": tends.value, "order": tends.order, "trust": tends.trust}
    return row | {"bar": tends.error / scale, "distance": abs(values[-1] - tends.value) / scale}


def of_statements(output: Path) -> pd.DataFrame:
    """The paper's statements on these flows, on its own cells and on the finest."""
    coarse, fine = (evaluate(output / f"cells-{cells}") for cells in (PAPERS, FINEST))
    both = coarse.merge(fine, on=["id", "section", "statement", "paper"], suffixes=("_5_mm", "_resolved"))
    judged = both["agrees_5_mm"].isin(("yes", "partly", "no")) | both["agrees_resolved"].isin(("yes", "partly", "no"))
    columns = ["id", "section", "statement", "paper", "ours_5_mm", "agrees_5_mm", "ours_resolved", "agrees_resolved"]
    return both.loc[judged, columns]


def across(run: Result) -> pd.DataFrame:
    """Across the silo in the middle of its height, means of columns of points: x and way downwards [mm], void ratio."""
    filled, now = run.state("filled"), run.state(-1)
    order, here = np.argsort(filled["identity"]), np.argsort(now["identity"])
    then, there = filled["position"][order], now["position"][here]
    top = then[:, 1].max()
    middle = (then[:, 1] > MIDDLE[0] * top) & (then[:, 1] < MIDDLE[1] * top)
    column = np.round(then[middle, 0] / run.scene.spacing_m - 0.5).astype(int)
    rows = {
        "x_mm": 1e3 * then[middle, 0],
        "way_mm": 1e3 * (then - there)[middle, 1],
        "void_ratio": now["void_ratio"][here][middle],
    }
    return pd.DataFrame(rows).groupby(column).mean().reset_index(drop=True)


def sheared_mm(profile: pd.DataFrame) -> tuple[float, float]:
    """Distances from the left wall between which the shear strain is above half of its greatest [mm]."""
    x, way = profile["x_mm"].to_numpy(), profile["way_mm"].to_numpy()
    left = x < 0.5 * (x[0] + x[-1])
    shear = np.gradient(way[left], x[left])
    above = x[left][shear > 0.5 * shear.max()]
    return float(above[0]), float(above[-1])


def _label(grid: str, run: Result) -> str:
    cells = f"{1e3 * run.scene.grid.cell_size_m:.3g} mm"
    return f"{cells}, walls left out" if grid == LEFT_OUT else cells


def draw_forces(results: dict[tuple[str, str], Result], file: Path) -> None:
    """P, T and N over the displacement of the bottom, a row a sand, a line a grid."""
    figure = new_figure(10.0, 3.2 * len(SANDS))
    axes = figure.subplots(len(SANDS), len(COLUMNS), sharex=True)
    for (sand, grid), run in results.items():
        flow = run.forces[run.forces.stage == "flow"]
        for axis, (force, column) in zip(axes[SANDS.index(sand)], COLUMNS.items(), strict=True):
            axis.plot(1e3 * flow.displacement_m, 1e-3 * flow[column], label=_label(grid, run), lw=1.0)
            axis.set_ylabel(f"{force}, {sand} sand (kN/m)")
    for axis in axes[-1]:
        axis.set_xlabel("way of the bottom (mm)")
    axes[0, 1].legend()
    figure.savefig(file, dpi=150)


def draw_profiles(results: dict[tuple[str, str], Result], file: Path) -> None:
    """Way downwards and void ratio from the wall to the middle, a row a sand, a line a grid."""
    figure = new_figure(9.0, 3.4 * len(SANDS))
    axes = figure.subplots(len(SANDS), 2, sharex=True)
    for (sand, grid), run in results.items():
        profile, row = across(run), axes[SANDS.index(sand)]
        left = profile[profile["x_mm"] < 500.0 * run.scene.silo.width_m]
        for axis, (name, label) in zip(
            row, (("way_mm", "way downwards (mm)"), ("void_ratio", "void ratio (-)")), strict=True
        ):
            axis.plot(left["x_mm"], left[name], label=_label(grid, run), lw=1.0)
            axis.set_ylabel(label)
        row[0].set_title(f"{sand} sand", loc="left")
    for axis in axes[-1]:
        axis.set_xlabel("distance from the wall (mm)")
    axes[0, 1].legend()
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    command_line.command(resolved_silo)
