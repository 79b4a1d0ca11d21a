"""Collapse of columns between smooth side walls, beside the experiments of Lube et al. (2005).

Loose Karlsruhe sand against one wall, its free side held by a smooth wall that is taken away at once, aspect ratios
a = H0 / L0 from 0.5 to 4. Beside the measured run-out and final height stands what statics alone would give: a wedge
of the sand's critical angle in plane shear, whose area is that of what has slid, without inertia. Leaves `column.csv`,
a row a column, and the figure of the surfaces.

Source: G. Lube, H. E. Huppert, R. S. J. Sparks, A. Freundt, Phys. Rev. E 72 (2005) 041301.

Cost: on 10 cells across L0 about one core-minute for a = 1, more for higher ones; on 20 three.
"""

import math
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.runs.collapse_findings import profile_of
from taichi_silo.runs.result import Result
from taichi_silo.runs.theories import critical_simple_shear_angle_deg
from taichi_silo.scene.scene import Scene
from taichi_silo.show.figures.style import COLORS, STYLE, new_figure
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

LENGTH_M, ASPECTS = 0.1, (0.5, 1.0, 2.0, 4.0)
VOID_RATIO, FLOOR_DEG = 0.80, 30.0


def scene_of(aspect: float, cells: int) -> Scene:
    """A column of an aspect ratio, on so many cells across L0."""
    cell = LENGTH_M / cells
    room = (1.0 + 1.6 * lube_run_out(aspect)) * LENGTH_M
    wide, high = math.ceil(room / cell) * cell, round(aspect * cells) * cell
    return Scene.model_validate(
        {
            "silo": {"width_m": round(wide, 9), "height_m": round(high, 9), "column_m": [0.0, LENGTH_M]},
            "sand": {"void_ratio": VOID_RATIO},
            "walls": {"kind": "smooth", "friction_angle_deg": 0.0, "bottom_friction_angle_deg": FLOOR_DEG},
            "grid": {"cell_size_m": cell, "points_per_cell": 4},
            "flow": {"outflow": "collapse"},
            "method": {"filling_time_s": 0.01, "longest_settling_s": 0.02},
            "output": {"records_per_period": 4, "snapshots": 30},
            "machine": {"threads": 1},
        }
    )


def lube_run_out(aspect: float) -> float:
    """(L - L0) / L0 in a channel; between a = 1.8 and 2.8 the greater of both regimes."""
    return 1.2 * aspect if aspect < 1.8 else max(1.2 * aspect, 1.9 * aspect ** (2.0 / 3.0))


def lube_height(aspect: float) -> float:
    """H / L0 at the end."""
    return aspect if aspect < 1.15 else aspect**0.4


def slid_wedge_run_out(aspect: float, angle_deg: float) -> float:
    """(L - L0) / L0 of a column that slides until its side stands at an angle, without inertia.

    What slides off above the toe lies beyond it: the side turns about its middle while it meets the top of the
    column, a < 2 tan(angle), else a triangle with the column's area is left.
    """
    tangent = math.tan(math.radians(angle_deg))
    if aspect < 2.0 * tangent:
        return aspect / (2.0 * tangent)
    return math.sqrt(2.0 * aspect / tangent) - 1.0


def drawn_run_out(run: Result) -> float:
    """(L - L0) / L0, the foot of the deposit drawn out: a straight line through its surface meets the floor there.

    The line is through the surface where it is thicker than a cell and lower than half its greatest height, beyond
    half of L0: the foot itself is thinner than a cell.
    """
    profile = profile_of(run.state(-1), run.scene)
    x, y = profile.middle_m, profile.height_m
    cell = run.scene.grid.cell_size_m
    side = (y > cell) & (y < 0.5 * profile.top_m) & (x > 0.5 * LENGTH_M)
    slope, height = np.polyfit(x[side], y[side], 1)
    return float(-height / slope) / LENGTH_M - 1.0


def row(aspect: float, run: Result) -> dict:
    """What a run has come to."""
    found = run.summary["collapse"]
    angle = critical_simple_shear_angle_deg(run.scene.sand.critical_friction_angle_deg)
    return {
        "aspect_ratio": aspect,
        "cells_across_L0": round(LENGTH_M / run.scene.grid.cell_size_m),
        "run_out_over_L0": found["run_out_over_L0"],
        "lube_run_out_over_L0": lube_run_out(aspect),
        "drawn_run_out_over_L0": drawn_run_out(run),
        "run_out_over_lube": found["run_out_over_L0"] / lube_run_out(aspect),
        "slid_wedge_over_L0": slid_wedge_run_out(aspect, angle),
        "height_over_L0": found["height_over_L0"],
        "lube_height_over_L0": lube_height(aspect),
        "height_over_lube": found["height_over_L0"] / lube_height(aspect),
        "slope_deg": found["slope_deg"],
        "seconds": found["front_at_rest_after_s"],
        "falls": found["front_at_rest_after_s"] / math.sqrt(aspect * LENGTH_M / 9.81),
        "energy_dissipated": found["energy_dissipated_over_first_potential"],
    }


def figure_of(runs: dict[float, Result]):
    """The surfaces at the end, over L0, and run-out and height against the aspect ratio."""
    figure = new_figure(11.0, 4.2)
    surfaces, found = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    a = np.geomspace(0.4, 5.0, 60)
    found.loglog(a, [lube_run_out(one) for one in a], color=COLORS[0], label="run-out, Lube et al.")
    found.loglog(a, [lube_height(one) for one in a], color=COLORS[1], label="height, Lube et al.")
    for number, (aspect, run) in enumerate(runs.items()):
        profile, one = profile_of(run.state(-1), run.scene), run.summary["collapse"]
        there = profile.height_m > 0.0
        surfaces.plot(profile.middle_m[there] / LENGTH_M, profile.height_m[there] / LENGTH_M, color=COLORS[number],
                      label=f"a = {aspect:g}")  # fmt: skip
        found.plot(aspect, one["run_out_over_L0"], "o", color=COLORS[0])
        found.plot(aspect, one["height_over_L0"], "s", color=COLORS[1])
    surfaces.set(xlabel="x / L₀", ylabel="height / L₀", aspect="equal", xlim=(0.0, None), ylim=(0.0, None))
    surfaces.legend()
    found.set_xticks((0.5, 1.0, 2.0, 4.0), labels=("0.5", "1", "2", "4"))
    found.set_yticks((0.5, 1.0, 2.0, 4.0), labels=("0.5", "1", "2", "4"))
    found.minorticks_off()
    found.set(xlabel="aspect ratio H₀ / L₀", ylabel="(L − L₀) / L₀ (dots), H / L₀ (squares)")
    found.legend()
    return figure


def column(
    output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/column_study"),
    cells: Annotated[int, Option(help="cells across L0")] = 20,
    aspects: Annotated[list[float] | None, Option("--aspect-ratio", help="only these, repeatable")] = None,
) -> None:
    """Let columns of several aspect ratios collapse, and compare run-out and height with experiments."""
    output = output.expanduser()
    chosen = tuple(aspects or ASPECTS)
    runs = {f"a = {aspect:g}": Run(scene_of(aspect, cells), output / f"a{aspect:g}_{cells}") for aspect in chosen}
    run_all(runs, output)
    results = {aspect: Result(runs[f"a = {aspect:g}"].folder) for aspect in chosen}
    table = pd.DataFrame([row(aspect, run) for aspect, run in results.items()])
    table.to_csv(output / "column.csv", index=False, float_format="%.4g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
    with rc_context(STYLE):
        figure_of(results).savefig(output / "column.png")
    print(output / "column.png")


if __name__ == "__main__":
    command_line.command(column)
