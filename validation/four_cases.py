"""The paper's four mass flows side by side: dense and loose sand, smooth and very rough walls.

Source: Krzyzanowski et al. (2020), section 6; the figures are the counterparts of figures 10 to 13. Each case has a
process of its own, as many at a time as there are cores; cases already there are kept.

Cost: about twelve minutes on two cores.
"""

import sys
from pathlib import Path
from typing import Annotated

from typer import Option

from taichi_silo import Averaging, Flow, Machine, Mesh, Method, Scene
from taichi_silo.cli import command_line, flags, model_silo
from taichi_silo.scene import sands
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation.case_figures import plot_cases  # noqa: E402
from validation.case_tables import write_tables  # noqa: E402

LAW, LENGTH_M = "gudehus-bauer", 0.0015  # the paper's


def four_cases(
    sand: flags.SandFlag = "karlsruhe",
    dense: Annotated[float, Option(help="void ratio of the dense fill [-]")] = 0.60,
    loose: Annotated[float, Option(help="void ratio of the loose fill [-]")] = 0.90,
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.005,
    speed: Annotated[float, Option(help="of the bottom [m/s]")] = 0.002,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.02,
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    output: Annotated[Path, Option(help="folder; one subfolder a case")] = Path("outputs/four_cases"),
    film: Annotated[bool, Option(help="draw the films")] = True,
):
    """Run the paper's four cases, and draw and tabulate them side by side."""
    output, runs = output.expanduser(), {}
    for packing, void_ratio in (("dense", dense), ("loose", loose)):
        for walls in ("smooth", "very-rough"):
            scene = Scene(
                sand=sands.sand(sand, void_ratio, law=LAW),
                walls=model_silo.walls(walls, void_ratio),
                grid=Mesh(cell_size_m=cell_size, shape=shape),
                averaging=Averaging(characteristic_length_m=LENGTH_M),
                flow=Flow(speed_m_per_s=speed, displacement_m=displacement),
                method=Method(**method),
                machine=Machine(threads=1),
            )
            runs[f"{packing}, {walls.replace('-', ' ')}"] = Run(scene, output / f"{packing}_{walls}", film)
    run_all(runs, output)
    folders = {name: run.folder for name, run in runs.items()}
    for file in (*plot_cases(folders, output / "figures"), *write_tables(folders, output)):
        print(file)


if __name__ == "__main__":
    command_line.command(four_cases)
