"""One element test: a piece of sand that strains alike everywhere, through the law alone or through the whole method.

Source: Krzyzanowski et al. (2020), section 4. The method's piece is one cell with four points between plates, in a
fluid whose pressure stays (triaxial, plane strain), or under a plate that floats (simple shear); no gravity. With more
cells dense sand would localise in a band, as a specimen does, and the test would no longer be one of an element.

Cost: less than a second through the point, some seconds through the method.
"""

import time
from pathlib import Path
from typing import Annotated, Literal

import pandas as pd
from matplotlib import rc_context
from typer import Argument, Option

from taichi_silo.cli import command_line, flags
from taichi_silo.mpm import runtime
from taichi_silo.runs.run_folder import claim, free_name, write_tables
from taichi_silo.scene import sands
from taichi_silo.show.figures.element import element_figure
from taichi_silo.show.figures.style import STYLE
from taichi_silo.studies.element_tests import COLUMNS, TESTS, ElementScene, curve_of


def scenario(
    test: Annotated[Literal[tuple(TESTS)], Argument(help="which test")],
    sand: flags.SandFlag = "karlsruhe",
    void_ratio: Annotated[float, Option(help="initial void ratio [-], between e_d and e_i at the pressure")] = 0.60,
    pressure: Annotated[
        float | None, Option(help="isotropic at the start [Pa], kept on the free sides; 50e3, oedometer 1e3")
    ] = None,
    strain: Annotated[
        float | None, Option(help="at the end: logarithmic axial strain or shear gamma [-]; 0.2, oedometer 0.04")
    ] = None,
    law: flags.LawFlag = "gudehus-bauer",
    through: Annotated[Literal["point", "mpm"], Option(help="the law alone, or the whole method")] = "point",
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    output: Annotated[Path | None, Option(help="folder; outputs/... if not given")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a test in the output folder")] = False,
):
    """Run one element test; leaves curve.csv, run.toml and figures/curve.png."""
    values = {"pressure_Pa": pressure, "strain": strain}
    scene = ElementScene(
        test=test, sand=sands.sand(sand, void_ratio, law=law), through=through, shape=shape, **method,
        **{name: value for name, value in values.items() if value is not None},
    )  # fmt: skip
    runtime.init()
    place = Path("outputs") / f"element_{test}_{scene.sand.name}_e{void_ratio:.2f}"
    folder = claim(output if output else free_name(place), overwrite)
    begun = time.time()
    rows = []
    try:
        for row in curve_of(scene):
            rows.append(row)
    finally:  # a test that fails keeps what it has reached
        curve = pd.DataFrame(rows, columns=COLUMNS)
        curve.to_csv(folder / "curve.csv", index=False, float_format="%.9g")
        write_tables(folder, scene.model_dump(exclude_none=True), {"wall_seconds": round(time.time() - begun, 3)})
    title = f"{test.replace('-', ' ').capitalize()}: {scene.sand.name.capitalize()} sand, "
    title += f"$e_0$ = {void_ratio:.2f}, {scene.pressure_Pa / 1e3:g} kPa"
    with rc_context(STYLE):
        (folder / "figures").mkdir(exist_ok=True)
        element_figure(curve, title, TESTS[test].sheared).savefig(folder / "figures" / "curve.png")
    best = curve.friction_angle_deg.idxmax()
    last = curve.iloc[-1]
    print(
        f"largest friction angle {curve.friction_angle_deg[best]:.2f} deg at a strain of "
        f"{100 * abs(curve.strain[best]):.2f} %, at the end {last.friction_angle_deg:.2f} deg; void ratio at the end "
        f"{last.void_ratio:.4f}"
    )
    print(folder / "curve.csv")
    print(folder / "figures" / "curve.png")


if __name__ == "__main__":
    command_line.command(scenario)
