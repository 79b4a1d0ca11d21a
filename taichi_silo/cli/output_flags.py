"""Flags of commands that run something: what they leave, and what they print."""

from pathlib import Path
from typing import Annotated

import typer

QuietFlag = Annotated[bool, typer.Option("--quiet", "-q", help="print errors only")]
JsonFlag = Annotated[
    bool, typer.Option("--json", help="print one JSON object with the result; all other words go to stderr")
]
OutputFlag = Annotated[Path | None, typer.Option(help="folder of the run; outputs/... if not given")]
OverwriteFlag = Annotated[bool, typer.Option("--overwrite", help="replace a run in the output folder")]
FilmFlag = Annotated[bool, typer.Option(help="draw void_ratio.mp4")]
FiguresFlag = Annotated[bool, typer.Option(help="draw figures/*.png")]
YesFlag = Annotated[bool, typer.Option("--yes", "-y", help="begin runs of more than an hour without asking")]
ExplainFlag = Annotated[
    bool, typer.Option("--explain", help="print which parts of the method the scene uses, and why, and stop")
]
