"""Plane strain compression of dense or loose sand: a shear band grows from a weak element.

Source: Krzyzanowski et al. (2020), section 5, figures 3 to 8; experiments by Vardoulakis (1980). A specimen of
40 x 140 mm stands between smooth plates in a fluid under pressure, which acts on the free sides wherever they move; the
middle of its bottom is fixed, gravity acts. Friction angles are those of the plate's force over the present width.

What to expect (e0 = 0.55, 50 kPa, l_c = 1.5 mm): a peak just below the 59.1 deg of sand that does not localise, at 1.2
to 1.4 % of shortening, where localisation becomes possible (57.6 deg at 1.13 %); then a band at 45 deg + psi/2 = 56.7
deg to the horizontal (Roscoe), and softening towards the 29.9 deg of a specimen cut by one critical band.

`--study NAME` runs all cases of one figure, `--study all` every one; cases that are there are kept.
"""

import json
from pathlib import Path
from typing import Annotated, Literal

import pandas as pd
from typer import Option

from taichi_silo.cli import command_line, flags
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.runs.run_folder import free_name
from taichi_silo.scene import sands
from taichi_silo.scene.scene import Averaging, Machine
from validation.biaxial.run import leave, run_case, summary_of
from validation.biaxial.scene import BiaxialScene
from validation.biaxial.studies import STUDIES, cost, differences, draw_study, table_of
from validation.biaxial.words import findings
from validation.in_parallel import in_parallel


def plane_strain_compression(
    void_ratio: Annotated[float, Option(help="initial void ratio [-], between e_d and e_i at the pressure")] = 0.55,
    pressure: Annotated[float, Option(help="of the fluid around the sides [Pa]")] = 50e3,
    sand: flags.SandFlag = "karlsruhe",
    law: flags.LawFlag = "gudehus-bauer",
    points_across: Annotated[
        int, Option(help="points along the width of 40 mm: a multiple of 4 (2 and 6 with 1 and 9 points a cell)")
    ] = 32,
    points_per_cell: Annotated[int, Option(help="1, 4 or 9; with 1 the band tears open from 3 % on")] = 4,
    characteristic_length: flags.LengthFlag = None,
    weight: flags.WeightFlag = "gaussian",
    weak_void_ratio: Annotated[float, Option(help="of the weak element on the left side [-]")] = 0.91,
    weak_height: Annotated[float, Option(help="of the weak element, over the height; the paper has 0.5")] = 0.55,
    speed: Annotated[float, Option(help="of the upper plate [m/s]")] = 0.05,
    shortening: Annotated[float, Option(help="at the end, u / height [-]")] = 0.05,
    noise_control: Annotated[str, Option(help="column | none")] = "column",
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    threads: Annotated[int, Option(help="CPU threads")] = 1,
    study: Annotated[Literal[(*STUDIES, "all")] | None, Option(help="run all cases of one figure")] = None,
    output: Annotated[Path | None, Option(help="folder; outputs/... if not given")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a test in the output folder")] = False,
):
    """Compress a specimen; leaves curve.csv, points.vtu, summary.json, run.toml and figures."""
    scene = BiaxialScene(
        sand=sands.sand(sand, void_ratio, law=law), pressure_Pa=pressure, points_across=points_across,
        points_per_cell=points_per_cell, weak_void_ratio=weak_void_ratio,
        weak_height=weak_height, speed_m_per_s=speed, shortening=shortening,
        averaging=Averaging(characteristic_length_m=characteristic_length, weight=weight),
        noise_control=noise_control, shape=shape, machine=Machine(threads=threads), **method,
    )  # fmt: skip
    if study is not None:
        plain = BiaxialScene(sand=sands.sand("karlsruhe", 0.55, law="gudehus-bauer"), machine=Machine())
        if scene.model_copy(update={"machine": Machine()}) != plain:
            raise BadInput("--study runs fixed cases; of the other flags only --output can be given with it")
        names = list(STUDIES) if study == "all" else [study]
        return run_studies(names, (output or Path("outputs/biaxial")).expanduser())
    folder = output if output else free_name(Path("outputs") / f"plane_strain_compression_e{void_ratio:.2f}")
    folder = leave(scene, folder, overwrite, say=True)
    summary = summary_of(folder)
    print(json.dumps(summary, indent=2))
    print(*findings(summary, pd.read_csv(folder / "curve.csv")), folder, sep="\n")
    return None


def run_studies(names: list[str], folder: Path) -> None:
    """Run the cases of some studies on all cores, then draw and tabulate each."""
    cases = {}
    for name in names:
        for label, changes in STUDIES[name].cases.items():
            case = STUDIES[name].scene(changes)
            cases.setdefault(STUDIES[name].folder(folder, label), case)
    costs = {place.name: cost(case) for place, case in cases.items()}
    failures = in_parallel(run_case, {place.name: (case, place) for place, case in cases.items()}, costs)
    for name, why in failures.items():
        raise RunFailed(f"in {len(failures)} of {len(cases)} cases, the first being {name}: {why}")
    for name in names:
        for file in draw_study(name, folder):
            print(file)
    runtime.init()
    table = pd.concat([table_of(name, folder) for name in STUDIES if STUDIES[name].is_there(folder)])
    table.to_csv(folder / "table.csv", index=False, float_format="%.5g")
    print(folder / "table.csv")
    apart = differences(folder)
    apart.to_csv(folder / "differences.csv", index=False, float_format="%.3g")
    print(apart.to_string(index=False, float_format=lambda value: f"{value:.3g}"))


if __name__ == "__main__":
    command_line.command(plane_strain_compression)
