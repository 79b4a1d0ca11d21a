"""Speed against accuracy: what each setting of the method costs, and how wrong it makes the answer.

Dense sand (e0 = 0.60) in the model silo of Krzyzanowski et al. (2020), section 6, between very rough and between smooth
walls. Every setting (bottom speed, cell size, points a cell, shape, transfer, order of the step, filter, time step,
mass scaling, noise control, precision, non-local length, law) is varied alone about a base, and some are combined; each
run is compared with a finer, slower one: P(u), T(u), N(u), wall stress over height, thickness of the wall zones. First
question: has N between very rough walls a limit as the bottom slows, and what governs it?

Leaves `chart.csv` (one row a setting), `scatter.csv` (runs that differ by rounding only: the floor of all errors),
`fidelity.toml` (three settings from the front), figures, and `points/`, one file a run: a restart goes on where it was.

Cost: the short chart some ten minutes on two cores; `--full`, hours. Both are told before they start.
"""

from pathlib import Path
from typing import Annotated

import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.runs.cost_estimate import START_S, at_pace
from taichi_silo.runs.run_folder import writable
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures.style import STYLE
from taichi_silo.utils import atomic_write
from taichi_silo.utils.console import Console
from validation.accuracy.fidelities import choose, write
from validation.accuracy.figures import error_figure, speed_figure
from validation.accuracy.limit import limit, sentence
from validation.accuracy.parameter_set import ParameterSet, kept
from validation.accuracy.plan import ROUNDING, ChartRow, chart_rows, paths, runs
from validation.accuracy.table import chart as table_of
from validation.accuracy.table import floors
from validation.accuracy.varied_settings import FULL, SHORT
from validation.accuracy.workers import pace, run_missing


def chart(
    full: Annotated[bool, Option("--full", help="finer, slower and more of everything: hours")] = False,
    walls: Annotated[str, Option(help="very-rough | smooth | both")] = "both",
    dial: Annotated[str, Option(help="all, or some settings by name, separated by commas")] = "all",
    jobs: Annotated[int | None, Option(help="runs at a time, one core each; all cores if not given", min=1)] = None,
    estimate: Annotated[bool, Option("--estimate", help="only say what it would cost")] = False,
    output: Annotated[Path, Option(help="folder")] = Path("outputs/chart"),
    overwrite: Annotated[bool, Option("--overwrite", help="run anew what is there")] = False,
):
    """Measure error against cost for every setting of the method."""
    planned = chart_rows(FULL if full else SHORT, walls, dial)
    if jobs is not None and jobs > cores():
        raise BadInput(f"jobs is {jobs}; this machine has 1 to {cores()} cores")
    jobs, output, wanted, names = jobs or cores(), output.expanduser(), runs(planned), {}
    folder = output / "points"
    for row in planned:
        names.setdefault(row.parameters.key, f"{row.walls}, {row.varied} {row.setting}")
    there = {} if overwrite else numbers(wanted, folder)
    runtime.init()
    seconds = pace(there, next(row.parameters for row in planned if row.varied == ROUNDING))
    costs = {key: at_pace(one.scene, seconds) for key, one in wanted.items() if key not in there}
    for key, cost in costs.items():
        print(f"{names[key]:60s} {cost.steps:12,} steps  {cost.core_seconds:9.3g} core-seconds")
    whole = sum(cost.core_seconds + START_S for cost in costs.values())
    longest = max((cost.core_seconds for cost in costs.values()), default=0.0)
    minutes = max(whole / jobs, longest) / 60.0
    print(f"{len(there)} runs are there, {len(costs)} to do: about {minutes:.1f} minutes on {jobs} cores", flush=True)
    if estimate:
        return
    writable(folder)
    for key in costs:
        (folder / f"{key}.json").unlink(missing_ok=True)
    lost = run_missing(wanted, names, seconds, folder, jobs, Console())
    leave(planned, numbers(wanted, folder), output)
    for key, why in lost.items():
        raise RunFailed(f"in {len(lost)} of {len(costs)} runs, the first being '{names[key]}': {why}")


def numbers(wanted: dict[str, ParameterSet], folder: Path) -> dict[str, dict]:
    """Read the numbers of all finished runs, by key."""
    found = {key: kept(one, folder) for key, one in wanted.items()}
    return {key: run for key, run in found.items() if run is not None}


def leave(planned: list[ChartRow], found: dict[str, dict], output: Path) -> None:
    """Leave tables, figures and named settings, and answer the first question."""
    if not found:
        return
    rows, scatter = table_of(planned, found, paths(planned)), floors(planned, found)
    for name, table in (("chart.csv", rows), ("scatter.csv", scatter)):
        with atomic_write.written(output / name) as passing:
            table.to_csv(passing, index=False, float_format="%.6g")
        print(output / name)
    for walls, some in rows.groupby("walls", sort=False):
        floor = scatter[scatter.walls == walls].iloc[0]
        with rc_context(STYLE):
            draw(error_figure(some, floor), output / f"error_cost_{walls}.png")
            series = some[some.purpose == "speed"]
            if not series.empty:
                draw(speed_figure(series, floor.error_N), output / f"speed_{walls}.png")
        answer(series, floor.error_N)
    rough = rows[rows.walls == rows.walls.iloc[0]]
    chosen = choose(rough, scatter.error_N.iloc[0])
    if chosen:
        write(chosen, output / "fidelity.toml")
        for name, one in chosen.items():
            print(f"{name:10s} {one.settings}: {one.words()}")


def draw(figure, file: Path) -> None:
    """Save a figure, and say where."""
    figure.savefig(file)
    print(file)


def answer(series: pd.DataFrame, scatter: float) -> None:
    """Say whether N has a limit as the bottom slows: one sentence a series."""
    for name, some in series.groupby("dial", sort=False):
        found = limit(some["flow.speed_m_per_s"], some.residual_N_N_per_m, scatter)
        if found is not None:
            print(sentence(name, found))


if __name__ == "__main__":
    command_line.command(chart)
