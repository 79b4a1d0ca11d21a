"""Many silos at once: scenes from files and every combination of varied values, one process a core.

Each run has one thread, a process and a folder of its own, which is named after what varies. Finished runs are kept: a
restart goes on where it was. A run that fails says why in its row, and stops no other.

Leaves `batch.csv`, one row a run, from the first finished run on; `figures/batch.png`, P, T and N of all runs; and the
runs' folders.

Cost: told before it starts, and alone with `--estimate`. Two cores do two runs in the time of one.
"""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo import cli
from taichi_silo.batch import table, variations
from taichi_silo.batch.runs import Run, costs, simulate
from taichi_silo.cost import START_S
from taichi_silo.faults import BadInput, RunFailed
from taichi_silo.fidelity import fidelity as named
from taichi_silo.folder import writable
from taichi_silo.plots import plot_batch
from taichi_silo.scene import cores
from taichi_silo.settings import changed


def batch(
    files: Annotated[
        list[Path] | None, Argument(help="scenes: run.toml files; what they leave out takes the defaults")
    ] = None,
    vary: Annotated[
        list[str] | None,
        Option(
            help="PATH=V1,V2,...: values at a dotted path of run.toml, such as walls.kind=smooth,very-rough, or "
            "sand=NAME,...; the word default stands for a value that is not given; may be repeated"
        ),
    ] = None,
    fidelity: Annotated[
        str | None, Option(help="draft | standard | converged: cell size and speed of all runs, unless varied")
    ] = None,
    jobs: Annotated[int | None, Option(help="runs at a time, one core each; all cores if not given", min=1)] = None,
    film: Annotated[bool, Option(help="draw the films")] = False,
    estimate: Annotated[bool, Option("--estimate", help="only say what it would cost")] = False,
    output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/batch"),
    overwrite: Annotated[bool, Option("--overwrite", help="run anew what is there")] = False,
):
    """Run every scene in FILES (the default silo without any) with every combination of the varied values."""
    if jobs is not None and jobs > cores():
        raise BadInput(f"jobs is {jobs}; this machine has 1 to {cores()} cores")
    jobs, folder = jobs or cores(), output.expanduser()
    varied, bases = [variations.variation(text) for text in vary or []], variations.bases(files or [])
    if fidelity is not None:
        bases = {name: changed(scene, named(fidelity).settings) for name, scene in bases.items()}
    scenes = variations.scenes(bases, varied)
    runs = {name: Run(scene, folder / name, film) for name, scene in scenes.items()}
    for run in () if overwrite else runs.values():
        run.check()
    missing = {name: run for name, run in runs.items() if overwrite or not run.finished}
    if not estimate:
        writable(folder)
    expected = tell(runs, missing, jobs)
    if estimate:
        return
    paths, failures = variations.differences(scenes, varied), {}

    def leave(name: str, trouble: str) -> None:
        if trouble:
            failures[name] = trouble
        table.leave(folder / "batch.csv", runs, paths, failures)

    leave("", "")
    simulate(missing, jobs, lambda words: print(words, flush=True), leave, expected)
    print(folder / "batch.csv")
    for file in plot_batch({name: run.folder for name, run in runs.items() if run.summary}, folder / "figures"):
        print(file)
    if failures:
        name, why = next(iter(failures.items()))
        raise RunFailed(f"in {len(failures)} of {len(missing)} runs, the first being '{name}': {why}")


def tell(runs: dict[str, Run], missing: dict[str, Run], jobs: int) -> dict:
    """Say what is there and what the rest will cost; returns the costs of the rest."""
    expected = costs(runs, list(missing)) if missing else {}
    seconds = {name: cost.core_seconds + START_S for name, cost in expected.items()}
    for name in sorted(expected, key=lambda name: -seconds[name]):
        cost = expected[name]
        print(f"{name:60s} {cost.points:9,} points {cost.steps:12,} steps  {cost.core_seconds:9.3g} core-seconds")
    minutes = max(sum(seconds.values()) / jobs, max(seconds.values(), default=0.0)) / 60.0
    there = len(runs) - len(missing)
    print(f"{there} runs are there, {len(missing)} to do: about {minutes:.1f} minutes on {jobs} cores", flush=True)
    return expected


if __name__ == "__main__":
    cli.command(batch)
