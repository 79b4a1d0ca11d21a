"""What noise does to the wall force: dense sand between smooth walls, with and without noise control.

The paper says "no damping was defined". Friction at the walls then feeds the column's slowest oscillation, plain
hypoplasticity ratchets under it, and the wall normal force N settles a third above the value that Janssen's theory
gives with the sand's own pressure ratio at rest. With a drag towards the recent mean motion it does not: `--all` tries
that for walls of 5 to 45 degrees and very rough ones, other cells, slendernesses, sands and speeds.

Cost: about two minutes on two cores; with `--all` ten more.
"""

from pathlib import Path
from typing import Annotated

import pandas as pd
from matplotlib.figure import Figure
from typer import Option

from taichi_silo import Flow, Machine, Mesh, Method, Scene, Silo, Walls
from taichi_silo.cli import command_line, flags
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene import sands
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.scene import Averaging
from taichi_silo.show.figures.style import BLUE, VERMILLION, new_figure
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

COLORS = {"none": VERMILLION, "column": BLUE}
# case: wall angle (None: very rough), void ratio, cells [m], points a cell, H / b, speed [m/s], sand
USUAL = {"angle": 19.0, "e": 0.60, "cell": 0.01, "points": 1, "slenderness": 2.5, "speed": 0.005, "sand": "karlsruhe"}
CASES = {
    **{f"{angle} deg": {"angle": float(angle)} for angle in (5, 12, 19, 22, 25, 28, 30, 35, 40, 45, 60)},
    "very rough": {"angle": None},
    **{f"30 deg, {1e3 * cell:g} mm cells": {"angle": 30.0, "cell": cell} for cell in (0.005, 0.0025)},
    "19 deg, 5 mm cells": {"cell": 0.005},
    "30 deg, four points a cell": {"angle": 30.0, "points": 4},
    **{
        f"{angle} deg, H = {ratio} b": {"angle": float(angle), "slenderness": float(ratio)}
        for ratio in (1, 5, 8, 12)
        for angle in (19, 30)
    },
    **{f"28 deg, {name} sand": {"angle": 28.0, "e": 0.70, "sand": name} for name in sorted(published())},
    "30 deg, 2 mm/s": {"angle": 30.0, "speed": 0.002},
    "30 deg, 10 mm/s": {"angle": 30.0, "speed": 0.01},
    "12.3 deg, loose": {"angle": 12.3, "e": 0.90},
}
LABELS = {"none": "no control, as in the paper", "column": "drag towards the mean motion"}


def noise_control(
    void_ratio: Annotated[float, Option(help="initial void ratio [-]")] = 0.60,
    sand: flags.SandFlag = "karlsruhe",
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.005,
    speed: Annotated[float, Option(help="of the bottom [m/s]")] = 0.005,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.005,
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    everything: Annotated[bool, Option("--all", help="try all kinds of walls, silos and sands as well")] = False,
    output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/noise_control"),
):
    """Compare the wall force with and without noise control."""
    output = output.expanduser()
    if everything:
        table = held(output)
        table.to_csv(output / "noise_control.csv", index=False, float_format="%.4g")
        print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
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


def held(output: Path) -> pd.DataFrame:
    """P, T and N over the weight after filling and at u = 3 mm for all `CASES`, and what became of the core."""
    runs = {}
    for number, (name, change) in enumerate(CASES.items()):
        case = USUAL | change
        kind = "very-rough" if case["angle"] is None else "smooth"
        scene = Scene(
            silo=Silo(width_m=0.2, height_m=0.2 * case["slenderness"]),
            sand=sands.sand(case["sand"], case["e"]),
            walls=Walls(kind=kind, friction_angle_deg=case["angle"]),
            grid=Mesh(cell_size_m=case["cell"], points_per_cell=case["points"]),
            averaging=Averaging(characteristic_length_m=0.0),
            flow=Flow(speed_m_per_s=case["speed"], displacement_m=0.003),
            machine=Machine(threads=1),
        )
        runs[name] = Run(scene, output / f"case_{number:02d}")
    run_all(runs, output)
    rows = []
    for name, run in runs.items():
        weight, found = run.scene.weight_N_per_m, run.summary
        forces = [
            found[when][key] / weight
            for when in ("filling", "residual")
            for key in ("bottom_N_per_m", "shear_N_per_m", "normal_N_per_m")
        ]
        theory = found["janssen"]["normal_N_per_m_K0"] / weight
        path = found["certificate"]["core_strain_path"]
        rows.append((name, *forces, forces[5] / forces[2], theory, path))
    columns = [
        "case",
        "P_filled",
        "T_filled",
        "N_filled",
        "P_flow",
        "T_flow",
        "N_flow",
        "ratio",
        "Janssen",
        "core_path",
    ]
    return pd.DataFrame(rows, columns=columns)


def draw(histories: dict[str, pd.DataFrame], scene: Scene) -> Figure:
    """N against time, filling and flow, with Janssen's value."""
    ratio = scene.sand.skeleton().rest_pressure_ratio(scene.sand.void_ratio)
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
