"""`taichi-silo calibrate`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console


def calibrate(
    lab: Annotated[Path, Argument(metavar="DIR", help="folder of CSV files of laboratory tests, or one file")],
    output: Annotated[
        Path, Option(metavar="DIR", help="folder of sand.toml, table and figures; those of the same lab are replaced")
    ] = Path("outputs") / "calibrate",
    overwrite: Annotated[bool, Option("--overwrite", help="replace another sand.toml in the output folder")] = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
):
    """Determine the constants of a sand from laboratory tests: oedometer, drained triaxial, angle of repose, limits.

    What a file holds follows from its columns, such as `axial stress [kPa]` with `void ratio`, or `axial strain [%]`
    with `q [kPa]`; a line `# cell pressure = 100 kPa` says what no column says. Leaves sand.toml for --sand,
    calibration.csv and figures.

        taichi-silo calibrate lab
        taichi-silo calibrate lab --output outputs/quarry
    """
    from rich import box
    from rich.table import Table

    from taichi_silo.studies.calibrate.constants import SYMBOLS
    from taichi_silo.studies.calibrate.whole import SAND
    from taichi_silo.studies.calibrate.whole import calibrate as calibrated

    console = Console(quiet=quiet, as_json=json)
    with console.status("reading the tests") as status:
        found = calibrated(lab, output, status, overwrite)
    table = Table(title=f"Constants of {found.name}", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for number, head in enumerate(("constant", "value", "95 % from", "to", "known", "first value", "from")):
        table.add_column(head, justify="right" if number in (1, 2, 3, 5) else "left", overflow="fold")
    for row in found.table.itertuples():
        scale, unit = {"Pa": (1e-6, " [MPa]"), "deg": (1.0, " [deg]")}.get(row.unit, (1.0, ""))
        numbers = [f"{scale * value:.4g}" for value in (row.value, row.low, row.high, row.first_value)]
        table.add_row(f"{SYMBOLS[row.constant]}{unit}", *numbers[:3], row.known, numbers[3], row.source)
    console.terminal.print(table)
    console.say(*found.words, "", f"The calibration is in {output}: {', '.join(file.name for file in found.files)}")
    typical = f"; in it {found.only_typical} are only typical, by no test" if found.only_typical else ""
    console.say(f"taichi-silo run mass_flow --sand {output / SAND} takes it{typical}.")
    console.result(found.as_json())
