"""`taichi-silo report`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console


def report(
    folder: Annotated[Path, Argument(metavar="DIR", help="folder of a run, also of one that failed or still runs")],
    output: Annotated[Path | None, Option(metavar="FILE", help="the page; DIR/report.html if not given")] = None,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
):
    """Make one page of a run: drawing, key numbers, trust, film, figures, parameters.

    The page needs no other file and no network: it can be sent as it is, read on a phone, and printed.

        taichi-silo report outputs/outlet_e0.60_very-rough
        taichi-silo report outputs/outlet_e0.60_very-rough --output outlet.html
    """
    from taichi_silo.show.report.page import report as written

    console = Console(quiet=quiet, as_json=json)
    page = written(folder, output)
    console.say(f"The report is {page} ({page.stat().st_size / 1e6:.1f} MB); open it in a browser.")
    console.result({"report": str(page), "bytes": page.stat().st_size})
