"""`taichi-silo converge`."""

from pathlib import Path
from typing import Annotated

import typer

from taichi_silo.cli.output_flags import JobsFlag, JsonFlag, QuietFlag, SchedulerFlag, SlurmFlag
from taichi_silo.utils.console import Console


def converge(
    file: Annotated[Path, typer.Argument(metavar="SCENE.toml", help="scene")],
    to: Annotated[
        str, typer.Option(metavar="ERROR", help="error asked for: forces over the weight, all else over itself")
    ] = "2%",
    of: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="number that it is asked of, may be given several times, such as N_residual or "
            "zone_thickness; P, T and N after filling and at the end if not given",
        ),
    ] = None,
    budget: Annotated[str, typer.Option(metavar="TIME", help="time by the clock: 20min, 1.5h, 90s")] = "20min",
    steps: Annotated[int, typer.Option(help="of the ladder, at most: 1 to 8")] = 8,
    jobs: JobsFlag = None,
    scheduler: SchedulerFlag = None,
    slurm: SlurmFlag = False,
    estimate: Annotated[bool, typer.Option("--estimate", help="only say what the first steps would cost")] = False,
    output: Annotated[
        Path | None, typer.Option(help="folder; one subfolder a run; outputs/converge-NAME if not given")
    ] = None,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:  # fmt: skip
    """Compute a scene on finer and finer cells until its numbers are sure enough, and give each with an error bar.

    Each step is told with its time before it begins; it stops when the error is met, or when the next step would take
    longer than the budget. What is there is kept: the same command, with a larger budget or a smaller error, goes on.
    Leaves converge.csv, converge.json, runs.csv, two figures and report.html.

    Examples: taichi-silo converge silo.toml --to 2%,
    taichi-silo converge silo.toml --to 5% --of N_residual --budget 1h
    """  # fmt: skip
    from taichi_silo.errors import BadInput
    from taichi_silo.runs.run_folder import named
    from taichi_silo.scene.scene_files import read_scene
    from taichi_silo.studies.converge.plan import HEADLINE, Plan, seconds, share
    from taichi_silo.studies.converge.study import FEWEST_STEPS, Study
    from taichi_silo.studies.sweep.clusters import cluster_of

    console = Console(quiet, json)
    plan = Plan(share(to), tuple(of or HEADLINE), seconds(budget), steps)
    cluster = cluster_of(scheduler, slurm, jobs)
    folder = output or Path("outputs") / f"converge-{named(file)}"
    study = Study(read_scene(file, threads=1), folder, plan, console, cluster)
    if estimate:
        told = {}
        for step in range(FEWEST_STEPS):
            expected = study.costs(step)
            told[step + 1] = study.minutes(expected)
            console.say(f"step {step + 1}: {len(expected)} runs to do, about {told[step + 1]:.3g} min")
        console.result({"minutes": told})
        return
    cluster.check()
    study.run()
    study.say()
    console.say(*map(str, study.left))
    console.result(study.result)
    if not study.numbers:
        raise BadInput(study.ended[0].lower() + study.ended[1:].rstrip("."))
