"""The dense, very rough model silo with a resolved characteristic length: walls in the non-local mean, or not.

The sand's own length, l_c = 3 d50 = 1.5 mm, on cells of 200 / 128 = 1.56 mm, as the layer test asks (h about l_c: 1 %).
Walls that sand sticks to are left out of the mean ("ignored"), or count as grains that do not strain ("rigid"). Leaves
the two runs, `wall_kernel.csv` with forces and zones, and `wall_kernel.png` with velocity and void ratio across the
silo. Cost: about forty minutes on two cores.
"""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from typer import Option

from taichi_silo import Averaging, Flow, Machine, Mesh, Method, Scene
from taichi_silo.cli import command_line, model_silo
from taichi_silo.runs.result import Result
from taichi_silo.scene import sands
from taichi_silo.scene.silo import Silo
from taichi_silo.show.figures.style import new_figure
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

WALLS = ("ignored", "rigid")
BAND = (0.4, 0.6)  # of the height, over which profiles are averaged


def wall_kernel(
    cells: Annotated[int, Option(help="across the silo")] = 128,
    speed: Annotated[float, Option(help="of the bottom [m/s]")] = 0.02,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.01,
    output: Annotated[Path, Option(help="folder; one subfolder a kernel")] = Path("outputs/wall_kernel"),
):
    """Run the silo with both kernels and compare zones and forces."""
    runs = {}
    for wall in WALLS:
        width = 0.2
        cell = width / cells
        scene = Scene(
            silo=Silo(width_m=width, height_m=round(0.5 / cell) * cell),
            sand=sands.sand("karlsruhe", 0.60, law="gudehus-bauer"),
            walls=model_silo.walls("very-rough", 0.60),
            grid=Mesh(cell_size_m=cell),
            averaging=Averaging(characteristic_length_m=0.0015, wall=wall),
            flow=Flow(speed_m_per_s=speed, displacement_m=displacement),
            method=Method(filling_time_s=0.3, longest_settling_s=0.2),
            machine=Machine(threads=1),
        )
        runs[wall] = Run(scene, output / wall, film=False)
    run_all(runs, output)
    table = pd.DataFrame([found(wall, run.folder) for wall, run in runs.items()])
    table.to_csv(output / "wall_kernel.csv", index=False, float_format="%.4g")
    draw({wall: profiles(run.folder) for wall, run in runs.items()}, output / "wall_kernel.png")
    print(table.T.to_string(header=False))


def found(wall: str, folder: Path) -> dict:
    """A row of the table: forces over W, angle, zones."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    weight, row = summary["weight_N_per_m"], {"wall": wall}
    for state in ("filling", "residual"):
        for short, name in (("P", "bottom_N_per_m"), ("T", "shear_N_per_m"), ("N", "normal_N_per_m")):
            row[f"{short}_{state}_over_W"] = summary[state][name] / weight
        row[f"angle_{state}_deg"] = summary[state]["wall_friction_angle_deg"]
    dilated = [summary["shear_zones"][side]["thickness_m"] for side in ("left", "right")]
    row["wall_zone_by_void_ratio_mm"] = 1e3 * np.mean([one for one in dilated if one is not None] or [np.nan])
    row["sheared_from_mm"], row["sheared_to_mm"] = shear_zone_mm(profiles(folder))
    inside = summary["zones_inside"]["zones"]
    row["zones_inside"] = len(inside)
    row["thickness_inside_mm"] = 1e3 * float(np.median([zone["thickness_m"] for zone in inside])) if inside else np.nan
    return row


def profiles(folder: Path) -> pd.DataFrame:
    """Across the silo in the middle of its height, means of columns of points: x and way downwards [mm], void ratio."""
    run = Result(folder)
    filled, now = run.state("filled"), run.state(-1)
    order, here = np.argsort(filled["identity"]), np.argsort(now["identity"])
    then, there = filled["position"][order], now["position"][here]
    top = then[:, 1].max()
    middle = (then[:, 1] > BAND[0] * top) & (then[:, 1] < BAND[1] * top)
    column = np.round(then[middle, 0] / run.scene.spacing_m - 0.5).astype(int)
    rows = {
        "x_mm": 1e3 * then[middle, 0],
        "way_mm": 1e3 * (then - there)[middle, 1],
        "void_ratio": now["void_ratio"][here][middle],
    }
    return pd.DataFrame(rows).groupby(column).mean().reset_index(drop=True)


def shear_zone_mm(across: pd.DataFrame) -> tuple[float, float]:
    """Distances from the left wall between which the shear strain is above half of its greatest [mm]."""
    x, way = across["x_mm"].to_numpy(), across["way_mm"].to_numpy()
    left = x < 0.5 * (x[0] + x[-1])
    shear = np.gradient(way[left], x[left])
    above = x[left][shear > 0.5 * shear.max()]
    return float(above[0]), float(above[-1])


def draw(across: dict[str, pd.DataFrame], file: Path) -> None:
    """Way downwards and void ratio over x, of both kernels."""
    figure = new_figure(9.0, 3.6)
    axes = figure.subplots(1, 2)
    for axis, (name, label) in zip(
        axes, (("way_mm", "way downwards [mm]"), ("void_ratio", "void ratio [-]")), strict=True
    ):
        for wall, table in across.items():
            axis.plot(table["x_mm"], table[name], label=f"walls {wall}")
        axis.set_xlabel("x [mm]")
        axis.set_ylabel(label)
    axes[0].legend()
    axes[1].axhline(0.6, color="0.7", lw=0.8, zorder=0)
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    command_line.command(wall_kernel)
