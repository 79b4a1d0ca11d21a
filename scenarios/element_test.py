"""One element test: a piece of sand that strains alike everywhere, through the law alone or through the whole method.

Source: Krzyzanowski et al. (2020), section 4. The method's piece is one cell with four points between plates, in a
fluid whose pressure stays (triaxial, plane strain), or under a plate that floats (simple shear); no gravity. With more
cells dense sand would localise in a band, as a specimen does, and the test would no longer be one of an element.

Cost: less than a second through the point, some seconds through the method.
"""

from pathlib import Path
from typing import Annotated, Literal

from typer import Argument, Option

from taichi_silo.cli import command_line, flags
from taichi_silo.runs.run_folder import free_name
from taichi_silo.scene import sands
from taichi_silo.studies.element_run import VOID_RATIO, element_test
from taichi_silo.studies.element_tests import TESTS
from taichi_silo.studies.measured_element import read_measured


def scenario(
    test: Annotated[Literal[tuple(TESTS)], Argument(help="which test")],
    sand: flags.SandFlag = "karlsruhe",
    void_ratio: Annotated[
        float | None,
        Option(help="initial void ratio [-], between e_d and e_i at the pressure; 0.60, or that of the first measured"),
    ] = None,
    pressure: Annotated[
        float | None,
        Option(
            help="isotropic at the start [Pa], kept on the free sides; that of the first measured, or 50e3, oedometer "
            "1e3"
        ),
    ] = None,
    strain: Annotated[
        float | None, Option(help="at the end: logarithmic axial strain or shear gamma [-]; 0.2, oedometer 0.04")
    ] = None,
    law: flags.LawFlag = "gudehus-bauer",
    measured: Annotated[
        list[Path] | None,
        Option(
            metavar="FILE", help="CSV of the same test, drawn over the curve; axial strain [%] with q [kPa] and the "
            "like as `taichi-silo calibrate` reads it; of shear, shear strain [%] with shear stress [kPa]",
        ),
    ] = None,
    through: Annotated[Literal["point", "mpm"], Option(help="the law alone, or the whole method")] = "point",
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    output: Annotated[Path | None, Option(help="folder; outputs/... if not given")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a test in the output folder")] = False,
):  # fmt: skip
    """Run one element test, and set it beside measured curves; leaves curve.csv, run.toml and figures/curve.png."""
    files = measured or []
    if void_ratio is None:
        there = (read_measured(test, file, None).void_ratio for file in files)
        void_ratio = next((e for e in there if e is not None), VOID_RATIO)
    material = sands.sand(sand, void_ratio, law=law)
    place = Path("outputs") / f"element_{test}_{material.name}_e{void_ratio:.2f}"
    done = element_test(
        test, material, output if output else free_name(place), pressure_Pa=pressure, strain=strain, through=through,
        measured=files, overwrite=overwrite, shape=shape, **method,
    )  # fmt: skip
    print(*done.words, *done.files, sep="\n")


if __name__ == "__main__":
    command_line.command(scenario)
