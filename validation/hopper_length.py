"""N above a hopper in flow, with and without a length of the law that the grid resolves.

Dense sand that flows out of a hopper shears in bands from wall to wall. Where the law has no length that the grid
resolves a band is a cell or two thick, and N follows the grid, and which wall the first band set out from. With a
length of a cell or more N must come out the same on two grids. Leaves `hopper_length.csv`.

Cost: a quarter of an hour on two cores.
"""

import sys
from pathlib import Path
from typing import Annotated

import pandas as pd
from typer import Option

from taichi_silo.cli import command_line, model_silo
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Method, Sand, Scene
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation.hoppers import STEEP, VOID_RATIO  # noqa: E402

SPEED_M_PER_S, SUNK_MM, SPAN_MM = 0.01, (2, 6, 12), 0.5  # means over the last of that before each
CASES = [  # cell size [mm], characteristic length [mm] (None: the sand's own, 3 d50), filter of the stresses
    (cell, length, filtering)
    for length, filters in ((10.0, ("patch", "none")), (None, ("patch",)))
    for filtering in filters
    for cell in (10.0, 5.0)
]  # fmt: skip


def hopper_length(output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/hopper_length")):
    """Let dense sand out of a hopper of 15 degrees with and without a resolved length, and tabulate N."""
    output = output.expanduser()
    runs = {}
    for number, (cell, length, filtering) in enumerate(CASES, start=1):
        scene = Scene(
            silo=STEEP, sand=Sand(void_ratio=VOID_RATIO), walls=model_silo.walls("smooth", VOID_RATIO),
            grid=Mesh(cell_size_m=1e-3 * cell, points_per_cell=4),
            averaging=Averaging(characteristic_length_m=length and 1e-3 * length),
            method=Method(stress_filter=filtering), machine=Machine(threads=1),
            flow=Flow(speed_m_per_s=SPEED_M_PER_S, displacement_m=1e-3 * SUNK_MM[-1]),
        )  # fmt: skip
        runs[f"{cell:g} mm, {length or 'own'}, {filtering}"] = Run(scene, output / f"{number}")
    run_all(runs, output)
    results = [Result(run.folder) for run in runs.values()]
    table = pd.DataFrame([row(*case, result) for case, result in zip(CASES, results, strict=True)])
    table.to_csv(output / "hopper_length.csv", index=False, float_format="%.4g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))


def row(cell_mm: float, length_mm: float | None, filtering: str, run: Result) -> dict:
    """N of each wall [N/m], the lesser first, at each displacement."""
    found: dict = {"cell_mm": cell_mm, "length_mm": length_mm or 3e3 * run.scene.sand.d50_m, "filter": filtering}
    sunk = 1e3 * run.flow["displacement_m"]
    for at in SUNK_MM:
        means = run.flow[(sunk > at - SPAN_MM) & (sunk <= at * (1.0 + 1e-9))].mean(numeric_only=True)
        forces = sorted(means[f"{side}_normal_N_per_m"] for side in ("left", "right"))
        found |= {f"N_lesser_{at}_mm": forces[0], f"N_greater_{at}_mm": forces[1]}
    return found


if __name__ == "__main__":
    command_line.command(hopper_length)
