"""The runs of a sweep in processes of their own: each alone, or on a graphics card several together."""

import json
import time
from collections.abc import Callable

from taichi_silo.runs.cost_estimate import START_S, Cost
from taichi_silo.runs.run_folder import claim
from taichi_silo.studies.sweep.batch import alike, lines
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.console import Console
from taichi_silo.utils.process_pool import ASKED_EVERY_S, ProcessPool, Task

PROGRAM = ("taichi_silo.studies.sweep",)  # that makes some runs
SEEN_S = 60.0  # after which a file system shows what another machine has written


def simulate(
    runs: dict[str, Run],
    pool: ProcessPool | int,
    console: Console = Console(),  # noqa: B008 - it is frozen
    ended: Callable[[str, str], None] = lambda name, failure: None,
    expected: dict[str, Cost] | None = None,
) -> dict[str, str]:
    """Run all in processes: from the start what is finished, and what was left from where it was.

    `pool` may be a number of processes at a time on this machine; on a graphics card there is one, which does several
    runs together. `ended` hears the name of each that has ended, and why it failed, a sentence, or nothing. If their
    costs are known, the longest is begun first. Returns the sentences of those that failed, by their names.
    """
    expected = expected or {}
    for run in runs.values():
        if run.finished:  # what is there is done, for whoever attempts it
            claim(run.folder, overwrite=True)
        run.folder.parent.mkdir(parents=True, exist_ok=True)
    batches = {", ".join(names): names for names in alike(runs)}
    tasks = []
    for title, names in batches.items():
        costs = {name: expected[name] for name in names if name in expected}
        line = lines({name: runs[name] for name in names}, {name: cost.steps for name, cost in costs.items()})
        seconds = sum(cost.core_seconds + START_S for cost in costs.values()) or 1.0
        tasks.append(Task(title, PROGRAM, line, seconds=seconds))
    failures: dict[str, str] = {}
    unseen = []

    def over(title: str, failure: str) -> str:
        names = batches[title]
        for name, why in zip(names, _each(failure, len(names)), strict=True):
            if not why and not runs[name].finished:
                unseen.append(name)
                continue
            if why:
                failures[name] = why
            ended(name, why)
        if any(name in unseen for name in names):
            return "its files are not here yet"
        spent = sum(runs[name].summary.get("cost", {}).get("seconds", 0.0) for name in names)
        return failure or f"{spent:.3g} core-s"

    pool = ProcessPool(pool) if isinstance(pool, int) else pool
    if any(run.scene.machine.arch != "cpu" for run in runs.values()):
        pool.jobs = 1  # the card's
    pool.run(tasks, console, over)
    for name in unseen:
        if failure := _seen(runs[name]):
            failures[name] = failure
        ended(name, failure)
    return failures


def _each(failure: str, count: int) -> list[str]:
    """Why each of so many runs of a process failed."""
    if count > 1 and failure.startswith("["):
        return json.loads(failure)
    return [failure] * count


def _seen(run: Run) -> str:
    """Wait until this machine sees a run that its worker has finished; returns why it does not, or nothing."""
    end = time.monotonic() + SEEN_S
    while not run.finished and time.monotonic() < end:
        time.sleep(ASKED_EVERY_S)
    return "" if run.finished else f"its worker finished it, but {run.folder} is not shared with this machine"
