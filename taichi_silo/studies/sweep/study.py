"""A sweep from its scenes to its table and figures."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from taichi_silo.runs.cost_estimate import START_S, Cost
from taichi_silo.runs.run_folder import claim, no_link, own, writable
from taichi_silo.show.figures import plot_batch, plot_response
from taichi_silo.studies.sweep import table
from taichi_silo.studies.sweep.clusters import cluster_of
from taichi_silo.studies.sweep.plan import Sweep, from_tables, read
from taichi_silo.studies.sweep.processes import simulate
from taichi_silo.studies.sweep.runs import Run, costs
from taichi_silo.studies.sweep.variations import SAND, differences, used
from taichi_silo.utils.bounded_reading import place
from taichi_silo.utils.console import Console
from taichi_silo.utils.file_lock import alone
from taichi_silo.utils.messages import counted
from taichi_silo.utils.process_pool import STOPPED

TABLE = "sweep.csv"
FIGURES = ("figures/forces.png", "figures/response.png")
LOCK = ".sweep"  # in the output: one sweep at a time


@dataclass
class Study:
    """The runs, the table and the figures of a sweep in a folder; what is there is run anew only to `overwrite` it.

    Attributes
    ----------
    runs : each with its scene and folder, by its name.
    table : a frame, a row for each run: what varied, forces, pressures, flow pattern, cost, whether it failed.
    failures : why runs failed, a sentence each, by their names.
    left : files of the table and the figures.

    """

    sweep: Sweep
    folder: Path
    console: Console
    overwrite: bool = False
    failures: dict[str, str] = field(default_factory=dict, init=False)

    def __post_init__(self):
        """Make all scenes, and refuse what is not possible."""
        self.folder = place(self.folder, "output").resolve()  # workers have other working folders
        scenes = self.sweep.scenes()
        self.columns = differences(scenes, self.sweep.paths)
        self.sweep.response.check(self.columns)
        self.runs = {name: Run(scene, self.folder / name, self.sweep.film) for name, scene in scenes.items()}
        for run in () if self.overwrite else self.runs.values():
            run.check()
        self.varied = self._varied()
        self.missing = {name: run for name, run in self.runs.items() if self.overwrite or not run.finished}

    def _varied(self) -> list[str]:
        """What to plot over: what was asked to vary; a whole table by its values; files by what differs."""
        asked = ["sand.name" if path == SAND else path for path in self.sweep.paths]
        inner = [path for one in asked for path in self.columns if path == one or path.startswith(f"{one}.")]
        tables = [used(run.scene, self.columns) for run in self.runs.values()]
        return [path for path in inner or self.columns if len({str(table[path]) for table in tables}) > 1]

    def estimate(self) -> dict[str, Cost]:
        """Say what is there and what the rest will cost; returns the costs of the rest. Starts Taichi."""
        expected = costs(self.runs, list(self.missing)) if self.missing else {}
        seconds = {name: cost.core_seconds + START_S for name, cost in expected.items()}
        for name in sorted(expected, key=lambda name: -seconds[name]):
            cost = expected[name]
            self.console.say(
                f"{name:60s} {cost.points:9,} points {cost.steps:12,} steps {cost.core_seconds:9.3g} core-s"
            )
        whole, at_once = sum(seconds.values()), self.sweep.cluster.at_once
        there = len(self.runs) - len(self.missing)
        words = f"{counted(there, 'run')} {'is' if there == 1 else 'are'} there, {len(self.missing)} to do"
        if not expected:
            self.console.say(words)
        elif any(run.scene.machine.arch != "cpu" for run in self.missing.values()):
            self.console.say(f"{words}: about {whole / 60.0:.1f} minutes on the graphics card, one after the other")
        elif at_once is None:
            self.console.say(f"{words}: about {whole / 3600.0:.3g} core-hours")
        else:
            minutes = max(whole / at_once, max(seconds.values(), default=0.0)) / 60.0
            self.console.say(f"{words}: about {minutes:.1f} minutes on {counted(min(at_once, len(self.runs)), 'core')}")
        return expected

    def run(self) -> None:
        """Do what is missing, and leave table and figures; `failures` says which runs failed.

        Raises BadInput if the folder cannot be written or another sweep has it, a processor is not there, or a
        scheduler does not answer.
        """
        for machine in {run.scene.machine for run in self.missing.values()}:
            machine.start()
        no_link(*(self.folder / name for name in (TABLE, f"{TABLE}.part", LOCK, "figures", *FIGURES)))
        writable(self.folder)
        for run in self.missing.values():
            if run.folder.exists():
                own(run.folder)
        with alone(self.folder / LOCK, 0.0, f"output {self.folder} is in use by another sweep"):
            expected = self.estimate()
            for run in self.missing.values() if self.overwrite else ():
                claim(run.folder, overwrite=True)
            self.rows = {name: table.row(name, run, self.columns) for name, run in self.runs.items()}
            self._leave()
            try:
                if self.missing:
                    self._do(expected)
            except KeyboardInterrupt:
                for name, run in self.missing.items():
                    self._ended(name, self.failures.get(name, "" if run.finished else STOPPED))
                raise
            finally:
                self._leave()
            self.figures = self._draw()

    @property
    def left(self) -> list[Path]:
        """Table and figures."""
        return [self.folder / TABLE, *self.figures]

    @property
    def result(self) -> dict:
        """For scripts."""
        return {
            "folder": self.folder, "table": self.folder / TABLE, "figures": [str(file) for file in self.figures],
            "runs": {name: bool(row["finished"]) for name, row in self.rows.items()},
            "begun": list(self.missing), "failures": self.failures,
        }  # fmt: skip

    def _do(self, expected: dict[str, Cost]) -> None:
        """Simulate what is missing; the table follows each run that ends."""

        def ended(name: str, failure: str) -> None:
            self._ended(name, failure)
            self._leave()

        with self.sweep.cluster.pool(self.folder, len(self.missing), self.sweep.retries) as pool:
            simulate(self.missing, pool, self.console, ended, expected)

    def _ended(self, name: str, trouble: str = "") -> None:
        if trouble:
            self.failures[name] = trouble
        self.rows[name] = table.row(name, self.runs[name], self.columns, self.failures.get(name, ""))

    def _leave(self) -> None:
        self.table = table.leave(self.folder / TABLE, self.rows.values())

    def _draw(self) -> list[Path]:
        there = {name: run.folder for name, run in self.runs.items() if self.rows[name]["P_filled_N_per_m"]}
        response, target = self.sweep.response, self.folder / "figures"
        return plot_response(self.table, self.varied, response, target) + plot_batch(there, target)


def sweep(
    plan: str | os.PathLike | Mapping[str, Any],
    folder: str | os.PathLike,
    *,
    overwrite: bool = False,
    jobs: int | None = None,
    scheduler: str | None = None,
    slurm: bool = False,
    progress: bool = True,
) -> Study:
    """Run a scene many times with other values, on all cores or a cluster, and leave a table and figures.

    Parameters
    ----------
    plan : tables of a sweep, or a file with them: `scene` (a `Scene`, its tables, or files), `grid` or
        `latin_hypercube` (what varies), `fidelity`, `film`, `response`, `cluster`.
    folder : where to leave the runs, one subfolder each, the table and the figures; what is finished there is kept.
    overwrite : run anew what is there.
    jobs, scheduler, slurm : where the runs are done; all cores of this machine if not given, and not in the plan.
    progress : say what it will cost, and how far it is.

    Returns
    -------
    The sweep: `table`, a row for each run, and `failures`, sentences by the names of runs that failed.

    Raises
    ------
    BadInput
        before any work, if a scene is not possible, or the folder cannot be used. A run that fails stops no other.

    """
    if isinstance(plan, Mapping):
        asked = from_tables(dict(plan), Path())
    else:
        asked = read(Path(plan))
    cluster = cluster_of(scheduler, slurm, jobs, asked.cluster)
    cluster.check()
    asked = asked.model_copy(update={"cluster": cluster})
    study = Study(asked, place(folder, "folder"), Console(quiet=not progress), overwrite)
    study.run()
    return study
