"""Runs the parameter sets of a chart, each in a process of its own, and says how far it is."""

import statistics
from pathlib import Path

from taichi_silo.runs.cost_estimate import START_S, at_pace, rehearse
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils.console import Console
from taichi_silo.utils.process_pool import ProcessPool, Task
from validation.accuracy.parameter_set import ParameterSet, kept


def pace(found: dict[str, dict], base: ParameterSet) -> float:
    """Seconds of a point and step on one core: median of the finished runs, or of a rehearsal of the base.

    Taichi has been started.
    """
    costs = [run["cost"] for run in found.values()]
    if costs:
        return statistics.median(cost["core_seconds"] / (cost["points"] * max(cost["steps"], 1)) for cost in costs)
    return rehearse(Simulation(base.scene)) / base.scene.points


def run_missing(
    wanted: dict[str, ParameterSet],
    names: dict[str, str],
    seconds_per_point_and_step: float,
    folder: Path,
    jobs: int,
    console: Console,
) -> dict[str, str]:
    """Run the parameter sets that have no file in a folder yet, the longest first; the folder is there.

    Parameters
    ----------
    wanted, names : parameter sets and what to call them, by key.
    seconds_per_point_and_step : of one core, from which the expected costs follow.
    folder : of the files, one a run, so that a restart goes on where it was.
    jobs : processes at a time.
    console : where to say how far they are.

    Returns
    -------
    Why, by key, for those that left no file.

    """
    tasks, keys = [], {}
    for key, one in wanted.items():
        if kept(one, folder) is None:
            name = names[key] if names[key] not in keys else f"{names[key]} ({key})"  # several may share a name
            keys[name] = key
            cost = at_pace(one.scene, seconds_per_point_and_step)
            tasks.append(
                Task(
                    name=name,
                    program=("validation.accuracy.parameter_set", str(folder)),
                    line=one.model_dump_json(),
                    environment={"TAICHI_SILO_PRECISION": one.precision},
                    seconds=cost.core_seconds + START_S,
                )
            )

    def ended(name: str, failure: str) -> str:
        run = kept(wanted[keys[name]], folder)
        return failure or f"{run['cost']['core_seconds']:.3g} core-seconds"

    failures = ProcessPool(jobs).run(tasks, console, ended)
    return {keys[name]: why for name, why in failures.items()}
