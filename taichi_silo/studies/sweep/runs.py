"""The runs of a batch: which are there, what the others cost, and each in a process of its own."""

import json
import os
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.runs.cost_estimate import START_S, Cost, at_pace, rehearse
from taichi_silo.runs.run_folder import MADE, claim, finished, parameters, program
from taichi_silo.scene import memory_need
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils.process_pool import Processes, Task

PROGRAM = ("taichi_silo.studies.sweep",)  # that makes one run


@dataclass(frozen=True)
class Run:
    """A scene of one thread, the folder that its run leaves, and whether a film belongs to it."""

    scene: Scene
    folder: Path
    film: bool = False

    @property
    def summary(self) -> dict:
        """What the run found, also when it failed; empty if the folder holds none, or that of another scene."""
        try:
            if self._other():
                return {}
            return json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))
        except (BadInput, OSError, ValueError):
            return {}

    @property
    def finished(self) -> bool:
        """Whether it is there, with all that belongs to it."""
        done = self.summary.get("finished", False) and finished(self.folder)
        drawn = (self.folder / "void_ratio.mp4").exists() or program(self.folder).get("film") == "ended early"
        return done and (not self.film or drawn)

    @property
    def begun(self) -> bool:
        """Whether the folder holds this run, and it has not come to its end."""
        try:
            return (self.folder / MADE).exists() and not finished(self.folder) and not self._other()
        except BadInput:
            return False

    def check(self) -> None:
        """Refuse a folder that holds the run of another scene."""
        if (self.folder / MADE).exists() and self._other():
            raise BadInput(f"output {self.folder} holds another scene's run; give another folder, or --overwrite it")

    def order(self, steps: int = 0) -> str:
        """JSON line that the program `taichi_silo.studies.sweep` reads: this run, and the number of steps expected."""
        scene, folder = self.scene.model_dump(mode="json"), os.fspath(self.folder)
        return json.dumps({"scene": scene, "folder": folder, "film": self.film, "steps": steps})

    @classmethod
    def of_order(cls, line: str) -> tuple["Run", int]:
        """What it was given."""
        given = json.loads(line)
        return cls(Scene.model_validate(given["scene"]), Path(given["folder"]), given["film"]), given["steps"]

    def _other(self) -> bool:
        tables = [parameters(scene) for scene in (read_scene(self.folder / MADE, threads=1), self.scene)]
        return tables[0] | {"machine": None} != tables[1] | {"machine": None}


def costs(runs: dict[str, Run], missing: list[str]) -> dict[str, Cost]:
    """What the missing runs will cost, at the pace of finished ones with the same formulas or of a rehearsal.

    Starts Taichi.

    Raises
    ------
    BadInput
        if a processor cannot be used, or the memory does not suffice.

    """
    paces, found = {}, {}
    for run in runs.values():
        cost = run.summary.get("cost", {}) if run.finished else {}
        if cost.get("steps"):
            paces.setdefault(_formulas(run.scene), []).append(cost["seconds"] / (cost["points"] * cost["steps"]))
    for machine in {runs[name].scene.machine for name in missing}:
        machine.start()
    for name in sorted(missing, key=lambda name: runs[name].scene.points):
        scene = runs[name].scene
        if _formulas(scene) not in paces:
            memory_need.check(scene)
            scene.machine.start()
            paces[_formulas(scene)] = [rehearse(Simulation(scene)) / scene.points]
        found[name] = at_pace(scene, statistics.median(paces[_formulas(scene)]))
    return found


def _formulas(scene: Scene) -> tuple:
    """What decides over the seconds of a point and step."""
    method, grid = scene.method, scene.grid
    variant = (method.transfer, method.stress_update, method.stress_filter)
    return scene.machine.arch, scene.machine.lanes, scene.sand.law, grid.shape, grid.points_per_cell, *variant


def simulate(
    runs: dict[str, Run], jobs: int, say=print, ended: Callable[[str, str], None] = lambda name, trouble: None,
    expected: dict[str, Cost] | None = None,
) -> dict[str, str]:  # fmt: skip
    """Run all, each in a process of its own: from the start what is finished, and what was left from where it was.

    Parameters
    ----------
    runs : by their names.
    jobs : at a time.
    say : hears how far they are, in sentences.
    ended : hears the name of each that has ended, and its trouble, a sentence, or nothing.
    expected : their costs, if they are known: the longest is begun first.

    Returns
    -------
    The sentences of those that failed, by their names.

    """
    tasks = []
    for name, run in runs.items():
        if run.finished:  # what is there is done, for whoever attempts it
            claim(run.folder, overwrite=True)
        cost = (expected or {}).get(name)
        seconds = cost.core_seconds + START_S if cost else 1.0
        tasks.append(Task(name, PROGRAM, run.order(cost.steps if cost else 0), seconds=seconds))

    def over(task: Task, trouble: str) -> str:
        ended(task.name, trouble)
        seconds = runs[task.name].summary.get("cost", {}).get("seconds", 0.0)
        return trouble or f"{seconds:.3g} core-seconds"

    return Processes(jobs, say).run(tasks, lambda task, line: part(line), over)


def part(line: str) -> float | None:
    """Of a run that is done, as its process says it; None of other lines."""
    try:
        return float(line)
    except ValueError:
        return None
