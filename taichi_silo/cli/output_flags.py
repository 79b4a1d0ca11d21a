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
JobsFlag = Annotated[
    int | None, typer.Option(help="runs at a time, one core each; all cores of this machine if not given", min=1)
]
SchedulerFlag = Annotated[
    str | None, typer.Option(help="address of a dask scheduler whose workers do the runs, such as tcp://host:8786")
]
SlurmFlag = Annotated[bool, typer.Option("--slurm", help="do the runs in jobs of Slurm")]
ExplainFlag = Annotated[
    bool, typer.Option("--explain", help="print which parts of the method the scene uses, and why, and stop")
]
CheckFlag = Annotated[bool, typer.Option("--check", help="only say whether the scene is possible, and its cost")]
