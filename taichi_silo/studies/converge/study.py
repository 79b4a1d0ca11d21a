"""A study of convergence from its first run to its report: step by step, as far as the error or the time asks."""

import json
import math
import os
import time
from dataclasses import dataclass, field
from pathlib import Path

from taichi_silo.api import checked
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs.cost_estimate import START_S, Cost
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import no_link, own, writable
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Scene
from taichi_silo.show.figures import draw_all
from taichi_silo.show.figures.convergence import FIGURES
from taichi_silo.show.report.convergence import with_error, write_page
from taichi_silo.show.report.words import NONE
from taichi_silo.studies.converge import table
from taichi_silo.studies.converge.estimate import Number, estimate
from taichi_silo.studies.converge.ladder import Ladder
from taichi_silo.studies.converge.plan import HEADLINE, MOST_STEPS, Plan, seconds, share
from taichi_silo.studies.converge.quantities import Quantity, quantities, words
from taichi_silo.studies.sweep.clusters import Cluster, Local, cluster_of
from taichi_silo.studies.sweep.processes import simulate
from taichi_silo.studies.sweep.runs import Run, costs
from taichi_silo.utils import atomic_write
from taichi_silo.utils.bounded_reading import place
from taichi_silo.utils.console import Console
from taichi_silo.utils.file_lock import alone

FEWEST_STEPS = 3  # that show an order
DEARER = 4.5  # ratio of the costs of a step and the one before, where those of its runs are not yet known
RETRIES = 3  # of a run whose process crashed
FOUND, TABLE, RUNS = "converge.json", "converge.csv", "runs.csv"
LOCK = ".converge"  # in the output: one study at a time


@dataclass
class Study:
    """The ladder of a scene in a folder; what is there is kept, so that the same command goes on."""

    scene: Scene
    folder: Path
    plan: Plan = field(default_factory=Plan)
    console: Console = field(default_factory=Console)
    cluster: Cluster = field(default_factory=Local)
    found: dict[str, dict[str, Quantity]] = field(default_factory=dict, init=False)  # what each run found, by its name
    numbers: dict[str, Number] = field(default_factory=dict, init=False)
    steps: int = field(default=0, init=False)
    ended: str = field(default="", init=False)
    met: bool = field(default=False, init=False)

    def __post_init__(self):
        """Make the ladder, and refuse a folder that holds another scene's."""
        self.folder = place(self.folder, "output").resolve()
        self.ladder = Ladder(self.scene)
        self.runs: dict[str, Run] = {}
        for step in range(FEWEST_STEPS):
            self._add(step)
        self._ours()

    def _ours(self) -> None:
        """Refuse runs of another scene, and a study of another one."""
        for run in self.runs.values():
            run.check()
        others = [file.parent.name for file in self.folder.glob("*/run.toml") if file.parent.name not in self.runs]
        if others and not any(run.folder.exists() for run in self.runs.values()):
            raise BadInput(f"output {self.folder} holds other runs, such as {others[0]}; give another folder")

    def _add(self, step: int) -> dict[str, Run]:
        """The runs of a step."""
        found = {name: Run(self.ladder.made(rung), self.folder / name) for name, rung in self.ladder.step(step).items()}
        self.runs |= found
        return found

    def costs(self, step: int) -> dict[str, Cost]:
        """What the runs of a step that are not there will cost. Starts Taichi."""
        missing = [name for name in self._add(step) if not self.runs[name].finished]
        return costs(self.runs, missing) if missing else {}

    def minutes(self, expected: dict[str, Cost]) -> float:
        """Time by the clock of runs that cost so much."""
        seconds = [cost.core_seconds + START_S for cost in expected.values()]
        at_once = self.cluster.at_once or len(seconds) or 1
        return max(sum(seconds) / at_once, max(seconds, default=0.0)) / 60.0

    def run(self) -> None:
        """Climb until the error is met or the time is over; leave numbers, table, figures and report.

        Raises BadInput if the folder cannot be written or another study has it; RunFailed if a run failed, after all
        that is known has been written.
        """
        self.scene.machine.start()
        no_link(*(self.folder / name for name in (FOUND, TABLE, RUNS, LOCK, "figures", "report.html")))
        writable(self.folder)
        began = time.monotonic()
        with alone(self.folder / LOCK, 0.0, f"output {self.folder} is in use by another study"):
            for step in range(self.plan.steps):
                expected = self._afford(step, time.monotonic() - began)
                if expected is None:
                    break
                self._climb(step, expected)
                if self._good_enough():
                    break
            else:
                self.ended = f"The ladder was to end after {self.plan.steps} steps."
            self._leave()

    def _afford(self, step: int, spent_s: float) -> dict[str, Cost] | None:
        """Say what a step costs; the costs of its missing runs, or None where there is no such step, or no time."""
        try:
            expected = self.costs(step)
        except BadInput as error:
            if step < FEWEST_STEPS:
                raise
            self.ended = f"The ladder ends here: {error}."
            return None
        minutes, left = self.minutes(expected), (self.plan.budget_s - spent_s) / 60.0
        rung = self.ladder.main(step)
        across = round(self.scene.silo.width_m / rung.cell_m)
        what = f"step {step + 1}: cells of {1e3 * rung.cell_m:.4g} mm, {across} across"
        if not expected:
            self.console.say(f"{what}: there already")
            return expected
        if minutes > left:
            self.ended = (
                f"The next step, cells of {1e3 * rung.cell_m:.4g} mm, takes about {minutes:.2g} min, and "
                f"{max(left, 0.0):.2g} min are left; the same command with --budget {_time(minutes)} goes on from here."
            )
            return None
        runs = "1 run" if len(expected) == 1 else f"{len(expected)} runs"
        self.console.say(f"{what}: {runs}, about {minutes:.2g} min")
        return expected

    def _climb(self, step: int, expected: dict[str, Cost]) -> None:
        """Do what is missing of a step, and renew what is known."""
        missing = {name: self.runs[name] for name in expected}
        for run in missing.values():
            if run.folder.exists():
                own(run.folder)
        if missing:
            with self.cluster.pool(self.folder, len(missing), RETRIES) as pool:
                failures = simulate(missing, pool, self.console, expected=expected)
            if failures:
                name, why = next(iter(failures.items()))
                self.ended = f"The run {name} failed: {why}."
                self._leave()
                raise RunFailed(f"in the run {name}: {why}")
        self.steps = step + 1
        self.found |= {name: quantities(Result(self.runs[name].folder)) for name in self.ladder.step(step)}
        self.numbers = estimate(self.ladder, self.steps, self.found)
        self._leave()

    def _good_enough(self) -> bool:
        """Whether the error is met; says how large it is."""
        worst = self.plan.worst(self.numbers)
        if worst is None:
            return False
        name, number = worst
        self.console.say(
            f"   largest error: {100.0 * number.relative:.2g} % of {name}, {table.measure(name, number)}, "
            f"most of it by the {number.decisive}"
        )
        self.met = self.steps >= FEWEST_STEPS and number.relative <= self.plan.error
        if self.met:
            self.ended = f"The error asked for, {100.0 * self.plan.error:.3g} %, is met."
        return self.met

    def say(self) -> None:
        """Tell a person what came out."""
        for name, number in self.numbers.items():
            value, unit = with_error(number.value, number.error, number.unit)
            relative = f"{100.0 * number.relative:7.2g} %" if math.isfinite(number.relative) else f"{NONE:>9s}"
            self.console.say(f"{name:24s} {value:>22s} {unit:5s} {relative}  {words(name)}")
        self.console.say(self.ended)

    @property
    def result(self) -> dict:
        """For scripts."""
        return {
            "folder": str(self.folder), "steps": self.steps, "met": self.met, "ended": self.ended,
            "asked": {"error": self.plan.error, "of": list(self.plan.of)},
            "quantities": {name: number.as_json() for name, number in self.numbers.items()},
        }  # fmt: skip

    def _leave(self) -> None:
        """Write numbers, table, figures and report, as far as they are known."""
        with atomic_write.written(self.folder / FOUND) as passing:
            passing.write_text(json.dumps(self.result, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        rows = table.of_numbers(self.numbers)
        runs = table.of_runs(self.ladder, self.runs, self.found, self.steps)
        for name, frame in ((TABLE, rows), (RUNS, runs)):
            with atomic_write.written(self.folder / name) as passing:
                frame.to_csv(passing, index=False, float_format="%.6g")
        self.left = [self.folder / name for name in (FOUND, TABLE, RUNS)]
        if self.steps > 1 and self.ended:
            figures = draw_all(FIGURES, (runs, rows), self.folder / "figures")
            write_page(self.folder / "report.html", self.scene, self.ended, rows, runs, figures)
            self.left += [*figures, self.folder / "report.html"]


def _time(minutes: float) -> str:
    """A time as `plan.seconds` reads it, rounded up."""
    return f"{int(minutes) + 1}min" if minutes < 120.0 else f"{int(minutes / 6.0 + 1.0) / 10.0:g}h"


def converge(
    scene: Scene | dict,
    folder: str | os.PathLike,
    *,
    to: float | str = 0.02,
    of: tuple[str, ...] = HEADLINE,
    budget: float | str = "20min",
    steps: int = MOST_STEPS,
    jobs: int | None = None,
    scheduler: str | None = None,
    slurm: bool = False,
    progress: bool = True,
) -> Study:
    """Compute a scene on finer and finer cells until its numbers are sure enough, and give each with an error bar.

    Parameters
    ----------
    scene : what to simulate, or its tables as a scene file has them.
    folder : where to leave the runs, the tables, the figures and the report; what is there is kept.
    to : error asked for, 0.02 or "2%": of forces over the weight of the sand, of all else over itself.
    of : the numbers that it is asked of, as `numbers` names them.
    budget : time by the clock, in seconds or as "20min".
    steps : of the ladder, at most.
    jobs, scheduler, slurm : where the runs are done, as in a sweep; all cores of this machine if not given.
    progress : say what each step will cost, and how far it is.

    Returns
    -------
    The study: `numbers` by name (`value`, `error`, `unit`, `relative`, `order`), `met`, and why it `ended`.

    Raises
    ------
    BadInput
        before any work, if the scene has no ladder, or the folder cannot be used.
    RunFailed
        if a run failed; the folder then holds everything up to that time.

    """
    scene = changed(checked(scene), {"machine.threads": 1})
    cluster = cluster_of(scheduler, slurm, jobs)
    cluster.check()
    plan = Plan(share(to), tuple(of), seconds(budget), steps)
    study = Study(scene, place(folder, "folder"), plan, Console(quiet=not progress), cluster)
    study.run()
    return study
