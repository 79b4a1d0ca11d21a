"""Hoppers, an insert and round silos: forces after filling and in flow, beside Walker's and Janssen's theories.

Dense sand between smooth walls on 5 mm cells, let out at 5 mm/s; where walls cut cells with four points a cell, one
hopper also with one. Leaves `hoppers.csv`, a row a state, and two figures:
the last pictures of the hopper and of the insert, and the stresses on the walls of the silo with a hopper.

Cost: three runs of twelve core-minutes, three of one to three.
"""

from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib import rc_context
from PIL import Image
from typer import Option

from taichi_silo.analysis.measure.wall_pressure import HOPPER_CELL_M, cell_mean
from taichi_silo.cli import command_line, model_silo
from taichi_silo.mpm import runtime
from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Flow, Machine, Mesh, Sand, Scene
from taichi_silo.scene.silo import Hopper, Insert, Outlet, Silo
from taichi_silo.show.figures.style import STYLE
from taichi_silo.show.figures.wall_stress import run_wall_stress_figure
from taichi_silo.show.film.films import still
from taichi_silo.show.film.look import Look
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

VOID_RATIO, DISPLACEMENT_M, PICTURE = 0.60, 0.02, (1920, 1080)
STEEP = Silo(hopper=Hopper(half_angle_deg=15.0, outlet_width_m=0.08))
SHALLOW = Silo(hopper=Hopper(half_angle_deg=45.0, outlet_width_m=0.08, friction_angle_deg=30.0))
ROOF = Silo(outlet=Outlet(width_m=0.08), inserts=(Insert(kind="roof", width_m=0.06, bottom_m=0.10),))
CASES = {  # silo, points a cell, how far the sand sinks [m]
    "hopper of 15°": (STEEP, 4, DISPLACEMENT_M),
    "hopper of 15°, one point a cell": (STEEP, 1, DISPLACEMENT_M),
    "hopper of 45°, its walls 30°": (SHALLOW, 4, DISPLACEMENT_M),
    "roof above an outlet": (ROOF, 4, DISPLACEMENT_M),
    "cylinder": (Silo(section="round"), 1, 0.25 * DISPLACEMENT_M),
    "cylinder, outlet of 80 mm": (Silo(section="round", outlet=Outlet(width_m=0.08)), 1, DISPLACEMENT_M),
}
BODIES = ("hopper_left", "hopper_right"), ("insert_1",)


def hoppers(output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/hoppers")):
    """Fill and empty silos that are not plain boxes, and tabulate what their parts carry."""
    output = output.expanduser()
    runs = {}
    for number, (name, (silo, points, displacement)) in enumerate(CASES.items(), start=1):
        scene = Scene(
            silo=silo, sand=Sand(void_ratio=VOID_RATIO), walls=model_silo.walls("smooth", VOID_RATIO),
            grid=Mesh(cell_size_m=0.005, points_per_cell=points),
            flow=Flow(speed_m_per_s=0.005, displacement_m=displacement), machine=Machine(threads=1),
        )  # fmt: skip
        runs[name] = Run(scene, output / f"{number}")
    run_all(runs, output)
    results = {name: Result(run.folder) for name, run in runs.items()}
    table = pd.DataFrame([row for name, result in results.items() for row in rows(name, result)])
    table.to_csv(output / "hoppers.csv", index=False, float_format="%.4g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
    for file in draw(output, *(results[name] for name in ("hopper of 15°", "roof above an outlet"))):
        print(file)


def rows(name: str, run: Result) -> list[dict]:
    """Forces [kN/m], and stresses on the hopper's wall [kPa], after filling and at the end of the flow."""
    theory, found = run.summary.get("theory") or {}, []
    for state, walker, means in (("filling", "filling", run.filled), ("residual", "discharge", run.residual)):
        assert means is not None, f"{name} has not ended"
        when = "filled" if state == "filling" else f"u = {1e3 * run.scene.flow.displacement_m:g} mm"
        row = {"silo": name, "state": when} | {letter: 1e-3 * means[letter] for letter in "PTN"}
        row["N_janssen"] = 1e-3 * run.summary["janssen"]["normal_N_per_m_K0"]
        row["N_lesser"], row["N_greater"] = sorted(1e-3 * means[f"{side}_normal_N_per_m"] for side in ("left", "right"))
        for bodies in BODIES:
            if f"{bodies[0]}_vertical_N_per_m" in means:
                row["sideways"] = 1e-3 * np.mean([abs(means[f"{body}_horizontal_N_per_m"]) for body in bodies])
                row["upwards"] = 1e-3 * np.mean([means[f"{body}_vertical_N_per_m"] for body in bodies])
        if f"walker_{walker}" in theory:
            known = theory[f"walker_{walker}"]
            row["P_walker"], row["upwards_walker"] = (
                1e-3 * known[f"{part}_force_N_per_m"] for part in ("outlet", "wall")
            )
            row["top_walker_kPa"] = 1e-3 * known["transition_normal_Pa"]
        if run.scene.silo.hopper is not None:
            row["top_kPa"], row["outlet_kPa"] = ends(run, state)
        found.append(row)
    return found


def ends(run: Result, state: str) -> tuple[float, float]:
    """Largest mean over 50 mm of the hopper's wall in its upper third, and that at the outlet, of both walls [kPa]."""
    top, low = [], []
    for wall in ("hopper_left", "hopper_right"):
        height, stress = run.profile(state, wall)
        mean = cell_mean(height, stress, HOPPER_CELL_M) / 1e3
        top.append(mean[height > 2.0 / 3.0 * run.scene.silo.transition_m].max())
        low.append(mean[0])
    return float(np.mean(top)), float(np.mean(low))


def draw(output: Path, hopper: Result, roof: Result) -> list[Path]:
    """The figures of the gallery."""
    runtime.init()
    pictures = []
    for number, run in enumerate((hopper, roof)):
        still(run, output / f"picture_{number}.png", -1, Look(size=PICTURE))
        pictures.append(Image.open(output / f"picture_{number}.png"))
    both = Image.new("RGB", (PICTURE[0], 2 * PICTURE[1]), "white")
    for number, picture in enumerate(pictures):
        both.paste(picture, (0, number * PICTURE[1]))
    files = [output / "hopper_and_roof.png", output / "hopper_wall_stress.png"]
    both.resize((960, 1080)).save(files[0])
    with rc_context(STYLE):
        figure = run_wall_stress_figure(hopper)
        assert figure is not None, "the hopper has no wall profiles"
        figure.savefig(files[1])
    return files


if __name__ == "__main__":
    command_line.command(hoppers)
