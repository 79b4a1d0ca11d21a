"""Flags of every command that speaks: how much, and to whom."""

from typing import Annotated

import typer

QuietFlag = Annotated[bool, typer.Option("--quiet", "-q", help="print errors only")]
JsonFlag = Annotated[
    bool, typer.Option("--json", help="print one JSON object with the result; all other words go to stderr")
]
