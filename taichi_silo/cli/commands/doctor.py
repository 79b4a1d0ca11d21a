"""`taichi-silo doctor`."""

from pathlib import Path
from typing import Annotated

import typer

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag


def doctor(
    output: Annotated[Path, typer.Option(help="folder where runs will be left")] = Path("outputs"),
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Check what runs need: Taichi, the processor's vector unit, a GPU, ffmpeg, a folder to write in, a small run.

    Ends with exit code 1 if something that every run needs is missing. Takes some ten seconds.
    """
    from taichi_silo.cli.doctor import examine
    from taichi_silo.utils.console import Console

    console = Console(quiet, json)
    found = []
    for finding in examine(output.expanduser()):
        found.append(finding)
        mark = {True: "ok", None: "--", False: "NO"}[finding.good]
        console.say(f"{mark}  {finding.what:22s} {finding.words}")
    console.result({finding.what: {"good": finding.good, "words": finding.words} for finding in found})
    if any(finding.good is False for finding in found):
        raise typer.Exit(1)
