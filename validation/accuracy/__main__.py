"""Speed against accuracy: what each dial of the method costs, and how wrong it makes the answer.

Dense sand (e0 = 0.60) in the model silo of Krzyzanowski et al. (2020), section 6, between very rough and between smooth
walls. Every dial (bottom speed, cell size, points a cell, shape, transfer, order of the step, filter, time step, mass
scaling, noise control, precision, non-local length, law) is turned alone about a base, and some are combined; each run
is compared with a finer, slower one: P(u), T(u), N(u), wall stress over height, thickness of the wall zones. First
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
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures.style import STYLE
from validation.accuracy.fidelities import choose, write
from validation.accuracy.figures import error_figure, speed_figure
from validation.accuracy.limit import limit, sentence
from validation.accuracy.plan import ROUNDING, Entry, entries, paths, runs
from validation.accuracy.points import kept
from validation.accuracy.table import chart as table_of
from validation.accuracy.table import floors
from validation.accuracy.varied_settings import FULL, SHORT
from validation.accuracy.workers import START_S, Workers, expected, pace


def chart(
    full: Annotated[bool, Option("--full", help="finer, slower and more of everything: hours")] = False,
    walls: Annotated[str, Option(help="very-rough | smooth | both")] = "both",
    dial: Annotated[str, Option(help="all, or some dials by name, separated by commas")] = "all",
    jobs: Annotated[int | None, Option(help="runs at a time, one core each; all cores if not given", min=1)] = None,
    estimate: Annotated[bool, Option("--estimate", help="only say what it would cost")] = False,
    output: Annotated[Path, Option(help="folder")] = Path("outputs/chart"),
    overwrite: Annotated[bool, Option("--overwrite", help="run anew what is there")] = False,
):
    """Measure error against cost for every dial of the method."""
    planned = entries(FULL if full else SHORT, walls, dial)
    if jobs is not None and jobs > cores():
        raise BadInput(f"jobs is {jobs}; this machine has 1 to {cores()} cores")
    jobs, folder, points, names = jobs or cores(), output.expanduser() / "points", runs(planned), {}
    for entry in planned:
        names.setdefault(entry.point.key, f"{entry.walls}, {entry.dial} {entry.setting}")
    there = {} if overwrite else numbers(points, folder)
    runtime.init()
    base = next(entry.point for entry in planned if entry.dial == ROUNDING)
    costs = expected(points, pace(there, base))
    missing = [key for key in points if key not in there]
    for key in missing:
        print(f"{names[key]:60s} {costs[key].steps:12,} steps  {costs[key].core_seconds:9.3g} core-seconds")
    whole = sum(costs[key].core_seconds + START_S for key in missing)
    longest = max((costs[key].core_seconds for key in missing), default=0.0)
    minutes = max(whole / jobs, longest) / 60.0
    print(f"{len(there)} runs are there, {len(missing)} to do: about {minutes:.1f} minutes on {jobs} cores", flush=True)
    if estimate:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"output {output} cannot be written: {error.strerror or error}") from error
    for key in missing:
        (folder / f"{key}.json").unlink(missing_ok=True)
    lost = Workers(folder, jobs, lambda words: print(words, flush=True)).run(points, names, costs)
    leave(planned, numbers(points, folder), output.expanduser())
    if lost:
        key, why = next(iter(lost.items()))
        raise RunFailed(f"in {len(lost)} of {len(missing)} runs, the first being '{names[key]}': {why}")


def numbers(points: dict, folder: Path) -> dict[str, dict]:
    """Of all finished points."""
    found = {key: kept(one, folder) for key, one in points.items()}
    return {key: run for key, run in found.items() if run is not None}


def leave(planned: list[Entry], found: dict[str, dict], output: Path) -> None:
    """Tables, figures, named settings, and the answer to the first question."""
    if not found:
        return
    rows, scatter = table_of(planned, found, paths(planned)), floors(planned, found)
    for name, table in (("chart.csv", rows), ("scatter.csv", scatter)):
        temporary = output / f"{name}.part"
        table.to_csv(temporary, index=False, float_format="%.6g")
        temporary.replace(output / name)
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
    """Whether N has a limit as the bottom slows: one sentence a series."""
    for name, some in series.groupby("dial", sort=False):
        found = limit(some["flow.speed_m_per_s"], some.residual_N_N_per_m, scatter)
        if found is not None:
            print(sentence(name, found))


if __name__ == "__main__":
    command_line.command(chart)
