"""What is asked before a run that takes long: at a terminal whether to begin, elsewhere nothing."""

import sys
from collections.abc import Callable

import typer

from taichi_silo.errors import Stopped
from taichi_silo.runs.cost_estimate import HOUR_S, clock
from taichi_silo.utils.console import Console

LESS = "larger cells, a faster bottom or a shorter way cost less (--set grid.cell_size_m=..., see --check)"
NOT_BEGUN = "not begun, as you answered, and nothing is written; " + LESS


def permission(console: Console, yes: bool) -> Callable[[float], None] | None:
    """A function that is told how many seconds a run will take, and asks a person at a terminal if they are many.

    It raises Stopped if the answer is no. Nobody is asked with `yes`, or where no terminal can answer: there a word
    says how to be asked less. None where nothing is said at all.
    """
    if console.quiet:
        return None

    def ask(seconds: float) -> None:
        if not seconds > HOUR_S:
            return
        words = f"The run takes about {clock(seconds)}"
        if yes or not sys.stdin.isatty():
            console.say(f"{words}; {LESS}.")
        elif not typer.confirm(f"{words}. Begin?", err=console.as_json):
            raise Stopped(NOT_BEGUN, 130)

    return ask
