"""`taichi-silo export`."""

from functools import partial
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console


def command(
    folder: Annotated[Path, Argument(help="of a run, also of one that goes on")],
    kind: Annotated[
        str,
        Option(
            "--format",
            help="vtkhdf (one file with time, for ParaView 5.12 and later) | csv (a table a state) | "
            "wall-loads (pressures on the walls, as tables and for Abaqus)",
        ),
    ] = "vtkhdf",
    output: Annotated[
        Path | None, Option(help="file, or folder of tables; FOLDER/silo.vtkhdf, FOLDER/csv or FOLDER/wall-loads")
    ] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace an export that is there")] = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Write all states of a run with the fields that follow from them, or its wall pressures, for other programs.

    Lengths are in m, times in s; other units are in the names. Examples:

    taichi-silo export outputs/silo

    taichi-silo export outputs/silo --format csv --output tables

    taichi-silo export outputs/silo --format wall-loads
    """
    from taichi_silo.show.export.whole import export

    console = Console(quiet, json)
    bar = partial(console.tracked, words="writing")
    done = export(folder, output, kind=kind, overwrite=overwrite, tracked=bar)
    console.say(f"{done.file}  {done.states} states, {done.bytes / 1e6:.3g} MB")
    console.result({"output": str(done.file), "format": kind, "states": done.states, "bytes": done.bytes})
