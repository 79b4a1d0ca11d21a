"""`taichi-silo export`."""

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
    from taichi_silo.errors import BadInput
    from taichi_silo.runs.result import Result
    from taichi_silo.runs.run_folder import no_link, writable
    from taichi_silo.show.export import tables, vtkhdf, wall_loads
    from taichi_silo.utils.bounded_reading import as_left, place
    from taichi_silo.utils.machine_faults import of_file

    formats = {"vtkhdf": (vtkhdf.write, "silo.vtkhdf"), "csv": (tables.write, "csv")}
    formats["wall-loads"] = (wall_loads.write, "wall-loads")
    if kind not in formats:
        raise BadInput(f"format is {kind}; it must be one of {', '.join(formats)}")
    console, run = Console(quiet, json), Result(folder)
    if kind != "wall-loads":
        run.need_states()
    elif not len(run.walls):
        raise BadInput(
            f"folder is {run.folder}; it must be that of a run with wall stresses, and its walls.csv has none"
        )
    write, name = formats[kind]
    target = place(output, "output") if output else run.folder / name
    there = any(target.glob("*")) if target.is_dir() else target.exists()
    if there and not overwrite:
        raise BadInput(f"output {target} is there already; give another name, or --overwrite to replace it")
    if target.exists() and target.is_dir() != (kind != "vtkhdf"):
        raise BadInput(f"output is {target}; it must be a {'file' if kind == 'vtkhdf' else 'folder'} for {kind}")
    no_link(target, target.with_name(f"{target.name}.part"), *(target.glob("*.*") if target.is_dir() else ()))
    writable(target.parent)
    with console.progress() as progress:
        task = progress.add_task("writing", total=len(run.snapshots))
        try:
            with as_left(run.folder):
                count = write(run, target, lambda: progress.advance(task))
        except OSError as error:
            raise of_file(error, target) from error
    files = [target] if target.is_file() else [*target.glob("*.*")]
    size = sum(file.stat().st_size for file in files)
    console.say(f"{target}  {count} states, {size / 1e6:.3g} MB")
    console.result({"output": str(target), "format": kind, "states": count, "bytes": size})
