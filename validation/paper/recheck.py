"""The paper's statements on silo flow (sections 6, 7 and 8) against our runs: what agrees, what does not, and why.

Reads the runs of the paper's cases, each in a subfolder named as the case (dense_very-rough_bottom,
loose_smooth_right-50, ...); a run that is not there is said so. Runs nothing: seconds.

Leaves `table.csv` and `table.md`: each statement with the paper's number, ours, and the verdict.
"""

import sys
from pathlib import Path
from typing import Annotated

from rich import box
from rich.console import Console
from rich.table import Table
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput
from validation.paper.check import VERDICTS, count, evaluate, write

COLOURS = {"yes": "green", "partly": "yellow", "no": "red"}


def paper_check(
    folder: Annotated[Path, Option(help="holds a subfolder for each case")] = Path("outputs/paper"),
    output: Annotated[Path | None, Option(help="where the tables go; the folder of the runs if not given")] = None,
    only: Annotated[str, Option(help="verdicts to print, separated by commas, or all; the files hold all")] = "all",
):
    """Compare every statement of the paper with the runs in a folder."""
    wanted = VERDICTS if only == "all" else tuple(word.strip() for word in only.split(","))
    for word in wanted:
        if word not in VERDICTS:
            raise BadInput(f"only is {word}; it must be all, or some of {', '.join(VERDICTS)}")
    table = evaluate(folder.expanduser())
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in ("id", "statement", "paper", "ours", "agrees", "why"):
        shown.add_column(column, overflow="fold", no_wrap=column == "agrees")
    for row in table[table.agrees.isin(wanted)].itertuples():
        colour = COLOURS.get(row.agrees, "default")
        cells = (row.id, row.statement, row.paper, row.ours, row.why)
        first, rest = [cell.replace("[", r"\[") for cell in cells[:4]], cells[4].replace("[", r"\[")
        shown.add_row(*first, f"[{colour}]{row.agrees}[/]", rest)
    console.print(shown)
    console.print(f"{len(table)} statements: " + ", ".join(f"{word} {number}" for word, number in count(table).items()))
    for file in write(table, output or folder.expanduser()):
        print(file)


if __name__ == "__main__":
    command_line.command(paper_check)
