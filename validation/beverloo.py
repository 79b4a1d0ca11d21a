"""Free outflow from a flat-floored silo: rate over the width of the outlet, and the dead edge of Beverloo's formula.

A slot lets out C rho sqrt(g) (D - D0)^(3/2). A straight line through rate^(2/3) over D gives C and the dead edge D0,
which a continuum without a length should not have: what it has is the grid's. Leaves `beverloo.csv`, a row a run, and
`beverloo_fit.csv`. Cost on 10 mm cells: 4 core-minutes with one point in each, 20 with four; on 5 mm 16 times that.
"""

import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from typer import Option

from taichi_silo import Averaging, Flow, Machine, Mesh, Sand, Scene, Walls
from taichi_silo.cli import command_line
from taichi_silo.mpm import runtime
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.simulation.simulation import Simulation

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation.in_parallel import in_parallel  # noqa: E402

SIZE_M = 0.4  # width and height of the silo
MEASURED = (0.05, 0.25)  # of the sand, between which the rate is taken
WIDTHS_MM = (60, 80, 100, 140)
GRIDS_MM, POINTS = (10.0, 5.0), (1, 4)


def beverloo(
    cells_mm: Annotated[list[float], Option("--cell-mm", help="grids; may be given more than once")] = list(GRIDS_MM),  # noqa: B006
    points_per_cell: Annotated[list[int], Option(help="points in a cell; may be given more than once")] = list(POINTS),  # noqa: B006
    output: Annotated[Path, Option(help="folder of the tables")] = Path("outputs/beverloo"),
):
    """Let sand fall out of outlets of several widths, and fit Beverloo's formula."""
    output.mkdir(parents=True, exist_ok=True)
    parts = {
        f"{cell:g} mm, {points} a cell, {width} mm": (cell, points, width, output)
        for cell in cells_mm for points in points_per_cell for width in WIDTHS_MM
    }  # fmt: skip
    costs = {name: points**1.2 * cell**-3.0 for name, (cell, points, _, _) in parts.items()}
    failures = in_parallel(rate_of, parts, costs)
    rows = [pd.read_csv(part_of(*part)) for name, part in parts.items() if name not in failures]
    table = pd.concat(rows)
    table.to_csv(output / "beverloo.csv", index=False, float_format="%.5g")
    fits = pd.DataFrame([fit(*which, rows) for which, rows in table.groupby(["cell_mm", "points_per_cell"])])
    fits.to_csv(output / "beverloo_fit.csv", index=False, float_format="%.4g")
    print(table.to_string(index=False), fits.to_string(index=False), sep="\n")


def part_of(cell_mm: float, points_per_cell: int, width_mm: float, output: Path) -> Path:
    """File of one run's row."""
    return output / f"part_{cell_mm:g}_{points_per_cell}_{width_mm:g}.csv"


def rate_of(cell_mm: float, points_per_cell: int, width_mm: float, output: Path) -> str:
    """Run one silo and write its row."""
    scene = Scene(
        silo=Silo(width_m=SIZE_M, height_m=SIZE_M, outlet=Outlet(width_m=1e-3 * width_mm)),
        sand=Sand(void_ratio=0.60),
        walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=1e-3 * cell_mm, points_per_cell=points_per_cell),
        averaging=Averaging(characteristic_length_m=0.0),
        flow=Flow(outflow="gravity", displacement_m=0.3 * SIZE_M * SIZE_M / (1e-3 * width_mm), longest_s=2.0),
        machine=Machine(threads=1),
    )
    runtime.init()
    simulation = Simulation(scene)
    list(simulation.fill())
    start, mass = simulation.time, simulation.model.mass
    times, gone = [], []
    for record in simulation.flow():
        times.append(record.time_s - start)
        gone.append(record.discharged_kg_per_m / mass)
        if gone[-1] > MEASURED[1]:
            break
    begin, end = np.interp(MEASURED, gone, times)
    rate = (MEASURED[1] - MEASURED[0]) * mass / (end - begin)
    scale = simulation.model.density * np.sqrt(9.81) * (1e-3 * width_mm) ** 1.5
    row = {
        "cell_mm": cell_mm, "points_per_cell": points_per_cell, "outlet_mm": width_mm,
        "cells_across": width_mm / cell_mm, "rate_kg_per_s_m": rate,
    }  # fmt: skip
    pd.DataFrame([row | {"over_rho_sqrt_g_D_1_5": rate / scale}]).to_csv(
        part_of(cell_mm, points_per_cell, width_mm, output), index=False
    )
    return f"{rate:.1f} kg/(s m)"


def fit(cell_mm: float, points_per_cell: int, rows: pd.DataFrame) -> dict:
    """C and dead edge of a grid with so many points in a cell."""
    slope, offset = np.polyfit(rows["outlet_mm"], rows["rate_kg_per_s_m"] ** (2.0 / 3.0), 1)
    unit = (rows["rate_kg_per_s_m"] / rows["over_rho_sqrt_g_D_1_5"] / (1e-3 * rows["outlet_mm"]) ** 1.5).iloc[0]
    dead = -offset / slope
    return {
        "cell_mm": cell_mm, "points_per_cell": points_per_cell, "C": (1e3 * slope) ** 1.5 / unit,
        "dead_edge_mm": dead, "dead_edge_cells": dead / cell_mm,
    }  # fmt: skip


if __name__ == "__main__":
    command_line.command(beverloo)
