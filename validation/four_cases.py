"""The paper's four mass flows side by side: dense and loose sand, smooth and very rough walls.

Source: Krzyzanowski et al. (2020), section 6; the figures are the counterparts of figures 10 to 13. Each case has a
process of its own, as many at a time as there are cores; cases already there are kept.

Cost: about twelve minutes on two cores.
"""

from pathlib import Path
from typing import Annotated

from typer import Option

from taichi_silo import Flow, Machine, Mesh, Method, Scene
from taichi_silo.cli import command_line, flags, model_silo
from taichi_silo.errors import RunFailed
from taichi_silo.runs.run_folder import writable
from taichi_silo.scene import sands
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures import plot_cases
from taichi_silo.studies.sweep.runs import Run, simulate

LAW = "gudehus-bauer"  # the paper's
CASES = {
    "dense, smooth": ("dense", "smooth"),
    "dense, very rough": ("dense", "very-rough"),
    "loose, smooth": ("loose", "smooth"),
    "loose, very rough": ("loose", "very-rough"),
}


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
    """Run the paper's four cases and draw them side by side."""
    runs = {}
    for name, (packing, walls) in CASES.items():
        scene = Scene(
            sand=sands.sand(sand, {"dense": dense, "loose": loose}[packing], law=LAW),
            walls=model_silo.walls(walls, {"dense": dense, "loose": loose}[packing]),
            grid=Mesh(cell_size_m=cell_size, shape=shape),
            flow=Flow(speed_m_per_s=speed, displacement_m=displacement),
            method=Method(**method),
            machine=Machine(threads=1),
        )
        runs[name] = Run(scene, output.expanduser() / name.replace(", ", "_").replace(" ", "-"), film)
    missing = {name: run for name, run in runs.items() if not run.finished}
    for name in (name for name in runs if name not in missing):
        print(f"{name:20s} kept", flush=True)
    writable(output)
    failures = simulate(missing, min(len(CASES), cores()), lambda words: print(words, flush=True))
    for name, why in failures.items():
        raise RunFailed(f"in the case '{name}': {why}")
    for file in plot_cases({name: run.folder for name, run in runs.items()}, output.expanduser() / "figures"):
        print(file)


if __name__ == "__main__":
    command_line.command(four_cases)
