"""Speed against accuracy: what each setting of the method costs, and how wrong it makes the answer.

The model silo of Krzyzanowski et al. (2020), section 6, between smooth, rough and very rough walls, filled with dense
and with loose sand, and one with an outlet. The truth of each scene is extrapolated from three grids, with its error
bar; each run turns one dial about a base of 10 mm cells, or is a named setting (`--fidelity`).

Leaves `chart.csv` (one row a setting), `truth.csv` (what they are compared with), `measured_errors.toml` (of the named
settings, for `taichi_silo.scene`), a figure, and the runs, which are kept: a restart goes on where it was.

Cost: an hour on two cores, half of it for the truth between very rough walls. It is told before.
"""

from pathlib import Path
from typing import Annotated

import tomli_w
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs.cost_estimate import START_S, Cost, at_pace, rehearse
from taichi_silo.runs.run_folder import claim, writable
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures.style import STYLE
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.studies.sweep.processes import simulate
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils import atomic_write
from taichi_silo.utils.console import Console
from validation.accuracy import study, table
from validation.accuracy.dials import dials
from validation.accuracy.figures import error_figure
from validation.accuracy.scenes import SCENES


def chart(
    full: Annotated[bool, Option("--full", help="every part of the method in every scene, not in one alone")] = False,
    walls: Annotated[
        str, Option(help="all, or scenes separated by commas, by name or by walls: very-rough, rough, smooth, outlet")
    ] = "all",
    dial: Annotated[str, Option(help="all, or some dials by name, separated by commas")] = "all",
    jobs: Annotated[int | None, Option(help="runs at a time, one core each; all cores if not given", min=1)] = None,
    estimate: Annotated[bool, Option("--estimate", help="only say what it would cost")] = False,
    output: Annotated[Path, Option(help="folder")] = Path("outputs/chart"),
    overwrite: Annotated[bool, Option("--overwrite", help="run anew what is there")] = False,
):
    """Measure error against cost for every setting of the method."""
    names, wanted = chosen("walls", walls, list(SCENES)), chosen("dial", dial, list(dials()))
    if jobs is not None and jobs > cores():
        raise BadInput(f"jobs is {jobs}; this machine has 1 to {cores()} cores")
    jobs, output, console = jobs or cores(), output.expanduser().resolve(), Console()
    rows = study.planned(names, wanted, output / "runs", full)
    runs = {f"{row.scene}, {row.dial} {row.setting}": row.run for row in rows}
    once = {run.folder: name for name, run in reversed(runs.items())}
    missing = {name: runs[name] for name in once.values() if overwrite or not runs[name].finished}
    expected = foretold(missing)
    seconds = [cost.core_seconds + START_S for cost in expected.values()]
    minutes = max(sum(seconds) / jobs, max(seconds, default=0.0)) / 60.0
    console.say(f"{len(once) - len(missing)} runs are there, {len(missing)} to do: about {minutes:.2g} minutes")
    if estimate:
        return
    writable(output)
    for run in missing.values() if overwrite else ():
        run.folder.mkdir(parents=True, exist_ok=True)
        claim(run.folder, overwrite=True)
    failures = simulate(missing, jobs, console, expected=expected) if missing else {}
    told = {name: study.truth(rows, name) for name in names}
    frame = study.rows(rows, told)
    for name, content in (("chart.csv", frame), ("truth.csv", study.known(told))):
        with atomic_write.written(output / name) as passing:
            content.to_csv(passing, index=False, float_format="%.6g")
        console.say(str(output / name))
    with atomic_write.written(output / "measured_errors.toml") as passing:
        tables = {"errors": study.of_fidelities(frame, told), "changes": study.of_changes(rows)}
        passing.write_text(tomli_w.dumps(tables), encoding="utf-8")
    with rc_context(STYLE):
        bars = {name: table.bars(truth)[table.WORST] for name, truth in told.items()}
        error_figure(frame, bars).savefig(output / "error_cost.png")
    console.say(str(output / "error_cost.png"))
    for name, why in failures.items():
        raise RunFailed(f"in {len(failures)} of {len(missing)} runs, the first being '{name}': {why}")


def foretold(missing: dict[str, Run]) -> dict[str, Cost]:
    """What runs will cost, all at the pace of the first of them. Starts Taichi."""
    if not missing:
        return {}
    first = next(iter(missing.values())).scene
    first.machine.start()
    pace = rehearse(Simulation(first)) / first.points
    return {name: at_pace(run.scene, pace) for name, run in missing.items()}


def chosen(flag: str, text: str, known: list[str]) -> list[str]:
    """The names of a flag, whole or by their first word, in the order that they are known in.

    Raises BadInput if one is not known.
    """
    asked = {name.strip() for name in text.split(",")} - {"all", "both"}
    found = {name: {name, name.split(" ")[0]} & asked for name in known}
    for name in sorted(asked - set().union(*found.values())):
        raise BadInput(f"{flag} is {name}; it must be all, or some of {', '.join(known)}")
    return [name for name in known if found[name] or not asked]


if __name__ == "__main__":
    command_line.command(chart)
