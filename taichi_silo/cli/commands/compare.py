"""`taichi-silo compare`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.errors import BadInput
from taichi_silo.utils.console import Console

FoldersArgument = Annotated[list[Path], Argument(metavar="DIR", help="runs; the others are set against the first")]
JanssenFlag = Annotated[bool, Option("--janssen", help="add Janssen's theory to figures and tables")]


def _no_paper(given: bool) -> None:
    if given:
        raise BadInput(
            "--paper is no more; python -m validation.paper.against_runs DIR ... sets runs beside what the paper states"
        )


PaperFlag = Annotated[bool, Option("--paper", hidden=True, is_eager=True, callback=_no_paper)]  # of version 0.2
CsvOption = Annotated[
    list[Path] | None,
    Option(
        "--csv", metavar="FILE",
        help="measurements, may be given several times; columns displacement_m, displacement_mm or time_s (since the "
        "outflow began) with P_kN_per_m, left_normal_N_per_m and the like, or height_m with normal_stress_kPa",
    ),
]  # fmt: skip
OutputOption = Annotated[
    Path,
    Option("--output", metavar="DIR", help="folder of tables and figures; an earlier comparison there is replaced"),
]


def compare(
    folders: FoldersArgument,
    janssen: JanssenFlag = False,
    paper: PaperFlag = False,
    csv: CsvOption = None,
    output: OutputOption = Path("outputs") / "compare",
    quiet: QuietFlag = False,
    json: JsonFlag = False,
):
    """Lay runs over each other: forces, wall stresses, and a table of their differences.

    Leaves compare.csv and two figures; with the flags janssen.csv, deviation.csv.

        taichi-silo compare outputs/smooth outputs/rough
        taichi-silo compare outputs/smooth --janssen
        taichi-silo compare outputs/rough --csv measured.csv
    """
    from taichi_silo.studies.compare import show
    from taichi_silo.studies.compare.whole import compare as compared

    console = Console(quiet=quiet, as_json=json)
    found = compared(folders, output, janssen=janssen, csv=csv or [])
    tables = [show.differences(found.differences)] if len(found.runs) > 1 else []
    tables += [] if found.janssen is None else [show.janssen(found.janssen)]
    if found.deviations is not None:
        tables += [show.deviations(rows) for _, rows in found.deviations.groupby("file", sort=False)]
    for table in tables:
        console.terminal.print(table)
    console.say(*found.remarks)
    console.say("", f"The comparison is in {output}: {', '.join(file.name for file in found.files)}")
    console.result(found.as_json())
