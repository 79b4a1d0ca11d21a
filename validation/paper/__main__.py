"""All silo flows of the paper: 4 mass flows, 12 controlled outflows, 1 free outflow; figures and table of statements.

Source: Krzyzanowski et al. (2020), sections 6 and 7. Each case has a process of its own, as many at a time as there are
cores; cases already there are kept, so that an interrupted series goes on where it was. At the end the counterparts of
the figures stand in `figures/`, and `table.md` sets each statement of the paper beside what was found here.

Cost: about 100 core-seconds a case and a film of 20 s each: half an hour on one core, a quarter on two.
"""

from pathlib import Path
from typing import Annotated

import pandas as pd
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run
from validation.paper import check
from validation.paper.cases import CASES
from validation.paper.figures import plot_paper
from validation.paper.one_line import one_line
from validation.paper.scenes import scenes


def paper(
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.005,
    speed: Annotated[float, Option(help="of the bottom or the gate [m/s]")] = 0.002,
    only: Annotated[str, Option(help="cases whose name contains this, such as loose_smooth")] = "",
    output: Annotated[Path, Option(help="folder; one subfolder a case")] = Path("outputs/paper"),
    film: Annotated[bool, Option(help="draw the films")] = True,
):
    """Run the paper's silo flows, draw them, and compare them with what the paper says."""
    output = output.expanduser()
    runs = {name: Run(scene, output / name, film) for name, scene in scenes(cell_size, speed).items() if only in name}
    if not runs:
        raise BadInput(f"only is {only!r}; it must be part of a case's name, such as {next(iter(CASES))}")
    failed = None
    try:
        run_all(runs, output)
    except RunFailed as error:  # what is there is drawn and judged all the same
        failed = error
    for file in plot_paper(output, output / "figures"):
        print(file)
    lines = pd.DataFrame([{"case": name, **one_line(run.summary)} for name, run in runs.items()])
    lines.to_csv(output / "runs.csv", index=False, float_format="%.5g")
    print(output / "runs.csv")
    table = check.evaluate(output)
    check.write(table, output)
    print("; ".join(f"{word}: {count}" for word, count in check.count(table).items()))
    print(output / "table.md")
    if failed is not None:
        raise failed


if __name__ == "__main__":
    command_line.command(paper)
