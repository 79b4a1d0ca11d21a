"""`taichi-silo eurocode`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console


def eurocode(
    scene: Annotated[Path | None, Argument(metavar="SCENE.toml", help="a scene file, or the run.toml of a run")] = None,
    output: Annotated[
        Path | None, Option(metavar="DIR", help="folder for the page, the figure, tables and loads for shell programs")
    ] = None,
    rows: Annotated[int, Option(help="depths of the table, 2 to 1000")] = 20,
    change: Annotated[
        list[str] | None,
        Option("--set", help="PATH=VALUE: another value, such as --set eurocode.solid=wheat; repeatable"),
    ] = None,
    solids: Annotated[bool, Option("--solids", help="print the solids of table E.1, and stop")] = False,
    overwrite: Annotated[bool, Option("--overwrite", help="replace what an earlier call left in the folder")] = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Compute the pressures of EN 1991-4 for a silo, without a simulation: a table by depth, and with --output a page.

    The table [eurocode] of the scene names the stored solid, the wall and the class; `taichi-silo scene` prints it.

    The numbers are characteristic values, without partial factors. Examples:

    taichi-silo eurocode silo.toml

    taichi-silo eurocode silo.toml --set eurocode.solid=wheat --output outputs/eurocode
    """
    from taichi_silo.cli import eurocode_words
    from taichi_silo.errors import BadInput
    from taichi_silo.scene.design import read_design
    from taichi_silo.show.report.eurocode import EurocodeReport

    console = Console(quiet, json)
    if solids:
        console.terminal.print(eurocode_words.solid_table())
        console.result(eurocode_words.solid_rows())
        return
    if scene is None:
        raise BadInput("SCENE.toml is not given; it must be a scene file, or --solids for the solids that it may name")
    if not 2 <= rows <= eurocode_words.MOST_ROWS:
        raise BadInput(f"rows is {rows}; it must be 2 to {eurocode_words.MOST_ROWS}")
    report = EurocodeReport.of(read_design(scene, change or ()), rows)
    assert report is not None, "a design has vertical walls"
    files = []
    if output is not None:
        from taichi_silo.show.report.eurocode_page import write

        files = write(report, output, scene, overwrite)
    for table in eurocode_words.tables(report):
        console.terminal.print(table)
    console.say(*(f"{name}: {value}" for name, value in report.facts.items()), *report.notes)
    if files:
        console.say("", f"The page is {files[0]}; beside it {', '.join(file.name for file in files[1:])}")
    console.result(report.as_json() | {"files": [str(file) for file in files]})
