"""What noise does to the wall force: dense sand between smooth walls, with and without noise control.

The paper says "no damping was defined". Friction at the walls then feeds the column's slowest oscillation, plain
hypoplasticity ratchets under it, and the wall normal force N settles a third above the value that Janssen's theory
gives with the sand's own pressure ratio at rest. With a drag towards the recent mean motion it does not.

Cost: about two minutes on two cores.
"""

from pathlib import Path
from typing import Annotated

import pandas as pd
from matplotlib.figure import Figure
from typer import Option

from taichi_silo import Flow, Machine, Mesh, Method, Scene, Walls
from taichi_silo.cli import command_line, flags
from taichi_silo.mpm.laws.gudehus_bauer import rest_pressure_ratio
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene import sands
from taichi_silo.show.figures.style import BLUE, VERMILLION, new_figure
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

COLORS = {"none": VERMILLION, "column": BLUE}
LABELS = {"none": "no control, as in the paper", "column": "drag towards the mean motion"}


def noise_control(
    void_ratio: Annotated[float, Option(help="initial void ratio [-]")] = 0.60,
    sand: flags.SandFlag = "karlsruhe",
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.005,
    speed: Annotated[float, Option(help="of the bottom [m/s]")] = 0.005,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.005,
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/noise_control"),
):
    """Compare the wall force with and without noise control."""
    output = output.expanduser()
    runs = {
        name: Run(
            Scene(
                sand=sands.sand(sand, void_ratio),
                walls=Walls(kind="smooth", friction_angle_deg=19.0),
                grid=Mesh(cell_size_m=cell_size, shape=shape),
                flow=Flow(speed_m_per_s=speed, displacement_m=displacement),
                method=Method(noise_control=name, **method),
                machine=Machine(threads=1),
            ),
            output / name,
        )
        for name in ("none", "column")
    }
    run_all(runs, output)
    figure = draw({name: pd.read_csv(run.folder / "forces.csv") for name, run in runs.items()}, runs["none"].scene)
    figure.savefig(output / "noise_control.png", dpi=150)
    print(output / "noise_control.png")


def draw(histories: dict[str, pd.DataFrame], scene: Scene) -> Figure:
    """N against time, filling and flow, with Janssen's value."""
    ratio = rest_pressure_ratio(scene.sand.skeleton(), scene.sand.void_ratio)
    theory = janssen_of(scene, scene.walls.friction_angle_deg, ratio)
    figure = new_figure(9.0, 4.6)
    axes = figure.subplots()
    for name, rows in histories.items():
        force = 0.5e-3 * (rows.left_normal_N_per_m + rows.right_normal_N_per_m)
        axes.plot(rows.time_s, force, color=COLORS[name], label=LABELS[name], linewidth=1.4)
        start = rows.time_s[rows.stage == "flow"].min()
        axes.axvline(start, color=COLORS[name], linestyle=":", linewidth=1.0)
    axes.axhline(
        1e-3 * theory.normal_force_N_per_m,
        color="0.4",
        linestyle="--",
        label=f"Janssen with the sand's own K0 = {ratio:.2f}",
    )
    axes.set(
        xlabel="time (s); dotted: the bottom starts to move", ylabel="wall normal force N (kN/m)", ylim=(0.0, None),
        title=f"Noise raises the wall force: e0 = {scene.sand.void_ratio:.2f}, smooth walls",
    )  # fmt: skip
    axes.legend(loc="lower right", frameon=False)
    return figure


if __name__ == "__main__":
    command_line.command(noise_control)
