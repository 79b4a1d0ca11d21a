"""How a silo is filled, and what of it is left in the flow: growing weight, layers, rain.

The paper says that its own filling, the whole column in place under a weight that grows, spoils the wall force, and
that layers would be better (section 6.1). Here the same silo is filled in the three ways and then flows; a table and a
figure set P, T, N after filling beside Janssen and the law's own pressure at rest, and what is left after 5 mm.

Cost: three runs of each wall, some 20 core-seconds each.
"""

import sys
from pathlib import Path
from typing import Annotated, get_args

import pandas as pd
from typer import Option

from taichi_silo.cli import command_line, model_silo
from taichi_silo.scene.scene import Averaging, Filling, Flow, Machine, Mesh, Sand, Scene, Silo
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation.case_figures import plot_cases  # noqa: E402

WAYS = get_args(Filling.model_fields["kind"].annotation)
NAMES = ("bottom_N_per_m", "shear_N_per_m", "normal_N_per_m")


def fillings(
    void_ratio: Annotated[float, Option(help="initial void ratio of the sand [-]")] = 0.60,
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.005,
    speed: Annotated[float, Option(help="of the bottom [m/s]")] = 0.005,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.005,
    layers: Annotated[int, Option(help="number of layers")] = 20,
    drop: Annotated[float, Option(help="height of fall of rain [m]")] = 0.02,
    output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/fillings"),
):
    """Fill the same silo in three ways, between smooth and very rough walls, and compare."""
    output = output.expanduser()
    runs = {}
    for walls in ("smooth", "very-rough"):
        for way in WAYS:
            scene = Scene(
                silo=Silo(half="no"), sand=Sand(void_ratio=void_ratio),
                walls=model_silo.walls(walls, void_ratio), grid=Mesh(cell_size_m=cell_size),
                averaging=Averaging(characteristic_length_m=0.0), filling=Filling(kind=way, layers=layers, drop_m=drop),
                flow=Flow(speed_m_per_s=speed, displacement_m=displacement), machine=Machine(threads=1),
            )  # fmt: skip
            runs[f"{walls}, {way}"] = Run(scene, output / f"{walls}_{way}")
    run_all(runs, output)
    rows = []
    for name, run in runs.items():
        found = run.summary
        row = {"run": name}
        for state in ("filling", "residual"):
            row |= {f"{state}_{letter}": found[state][key] for letter, key in zip("PTN", NAMES, strict=True)}
        row |= {f"N_over_janssen_{key}": 1.0 + found["janssen"][f"normal_N_per_m_{key}_relative_difference"]
                for key in ("K0", "measured")}  # fmt: skip
        row["mean_void_ratio_drift"] = found["certificate"]["mean_void_ratio_drift"]
        row["K_measured"] = found["janssen"]["pressure_ratio_measured"]
        rows.append(row)
    table = pd.DataFrame(rows)
    table.to_csv(output / "fillings.csv", index=False, float_format="%.5g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
    for walls in ("smooth", "very-rough"):
        cases = {way: runs[f"{walls}, {way}"].folder for way in WAYS}
        for file in plot_cases(cases, output / "figures" / walls):
            print(file)


if __name__ == "__main__":
    command_line.command(fillings)
