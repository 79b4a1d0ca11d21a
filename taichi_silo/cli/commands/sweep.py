"""`taichi-silo sweep`."""

from pathlib import Path
from typing import Annotated

import typer

from taichi_silo.cli.output_flags import JobsFlag, JsonFlag, QuietFlag, SchedulerFlag, SlurmFlag
from taichi_silo.utils.console import Console
from taichi_silo.utils.messages import counted


def sweep(
    file: Annotated[
        Path | None, typer.Argument(metavar="SWEEP.toml", help="what varies, in which scene; or --vary and --scene")
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            help="without a file, PATH=V1,V2,...: values at a dotted path of run.toml, such as silo.outlet.width_m="
            "0.04,0.08, or sand=NAME,...; the word default stands for a value that is not given; every combination of "
            "several --vary is run"
        ),
    ] = None,
    scene: Annotated[
        list[Path] | None, typer.Option(help="without a file: scene (TOML) to vary; several are all run")
    ] = None,
    fidelity: Annotated[
        str | None,
        typer.Option(help="draft | standard | fine | converged: cell size and speed of all runs, unless they vary"),
    ] = None,
    film: Annotated[bool | None, typer.Option(help="draw the films")] = None,
    jobs: JobsFlag = None,
    scheduler: SchedulerFlag = None,
    slurm: SlurmFlag = False,
    estimate: Annotated[bool, typer.Option("--estimate", help="only say what it would cost")] = False,
    output: Annotated[
        Path | None, typer.Option(help="folder; one subfolder a run; outputs/ and the file's name if not given")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="run anew what is there")] = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Run a scene many times with other values, on all cores or a cluster, and plot what comes out against them.

    SWEEP.toml says what varies: every combination of a grid, or the draws of a latin_hypercube. A run that is
    finished is kept: after Ctrl-C, a failure or a lost machine the same command goes on. A run that fails says why in
    its row of sweep.csv, and stops no other.

    Examples: taichi-silo sweep outlets.toml --estimate,
    taichi-silo sweep --vary silo.outlet.width_m=0.04,0.08 --vary sand=karlsruhe,hostun --fidelity draft
    """
    from taichi_silo.errors import RunFailed
    from taichi_silo.runs.run_folder import named
    from taichi_silo.studies.sweep.plan import from_command_line
    from taichi_silo.studies.sweep.study import Study

    console = Console(quiet, json)
    flags = {"fidelity": fidelity, "film": film, "jobs": jobs, "scheduler": scheduler, "slurm": slurm}
    plan = from_command_line(file, scene or [], vary or [], flags)
    if not estimate:
        plan.cluster.check()
    study = Study(plan, output or Path("outputs") / (named(file) if file else "sweep"), console, overwrite)
    if estimate:
        costs = study.estimate()
        seconds = {name: cost.core_seconds for name, cost in costs.items()}
        console.result({"runs": len(study.runs), "missing": list(study.missing), "core_seconds": seconds})
        return
    study.run()
    console.say(*map(str, study.left))
    console.result(study.result)
    if study.failures:
        name, why = next(iter(study.failures.items()))
        raise RunFailed(
            f"in {len(study.failures)} of {counted(len(study.missing), 'run')}, the first being '{name}': {why}"
        )
