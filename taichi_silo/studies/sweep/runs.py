"""The runs of a sweep: which are there, what is left of one, and what the others cost."""

import json
import math
import os
import platform
import statistics
from dataclasses import dataclass
from pathlib import Path

from taichi_silo import api
from taichi_silo.errors import BadInput, way
from taichi_silo.runs import film_states
from taichi_silo.runs.cost_estimate import Cost, at_pace, rehearse
from taichi_silo.runs.result import FILM
from taichi_silo.runs.run_folder import MADE, finished, parameters
from taichi_silo.scene import memory_need
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.scene.symmetry import half_model
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils import plugin_files
from taichi_silo.utils.file_lock import alone

LOCK = ".running"  # in the folder of a run
WAIT_S = 600.0  # for the process of an earlier attempt, whose worker is gone, to put its files in order


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
        filmed = any((self.folder / name).exists() for name in (FILM, film_states.NAME))
        return done and (not self.film or filmed)

    @property
    def begun(self) -> bool:
        """Whether the folder holds this run, and it has not come to its end."""
        try:
            return (self.folder / MADE).exists() and not finished(self.folder) and not self._other()
        except BadInput:
            return False

    @property
    def formulas(self) -> tuple:
        """What decides over the seconds of a point and step."""
        method, grid = self.scene.method, self.scene.grid
        variant = (method.transfer, method.stress_update, method.stress_filter, half_model(self.scene)[0])
        machine, law = self.scene.machine, self.scene.sand.law
        return machine.arch, machine.lanes, law, grid.shape, grid.points_per_cell, *variant

    def check(self) -> None:
        """Refuse a folder that holds the run of another scene."""
        if (self.folder / MADE).exists() and self._other():
            anew = way("overwrite")
            words = f"output {self.folder} holds another scene's run; give another folder, or {anew} to replace it"
            raise BadInput(words, anew)

    def attempt(self, extra: tuple = ()) -> None:
        """Do what is left: nothing if another attempt has finished it by now, the rest if one has begun it, or all.

        This is the one place that decides about what an earlier attempt left. No two processes attempt a run at once.
        `extra` are further observers.

        Raises BadInput if the folder cannot be written, or another process does not let go of it; RunFailed, Stopped as
        `session.run`.
        """
        if not self.folder.parent.is_dir():
            here = f"output {self.folder.parent} is not there on {platform.node()}"
            raise BadInput(f"{here}; it must be on a file system that all workers share")
        self.folder.mkdir(exist_ok=True)
        with alone(self.folder / LOCK, WAIT_S, f"output {self.folder} is being written by another process"):
            if not self.finished and not self._went_on(extra):
                api.run(self.scene, self.folder, overwrite=True, film=self.film, progress=False, extra=extra)

    def to_json(self, steps: int = 0) -> str:
        """The line that the program `taichi_silo.studies.sweep` reads: this run, and the number of steps expected."""
        scene, folder = self.scene.model_dump(mode="json"), os.fspath(self.folder)
        plugins = plugin_files.loaded()  # without which the scene may not be possible
        return json.dumps({"scene": scene, "folder": folder, "film": self.film, "steps": steps, "plugins": plugins})

    @classmethod
    def from_json(cls, line: str) -> tuple["Run", int]:
        """The run, and the number of steps expected."""
        given = json.loads(line)
        for file in given["plugins"]:
            plugin_files.load(file)
        return cls(Scene.model_validate(given["scene"]), Path(given["folder"]), given["film"]), given["steps"]

    def _other(self) -> bool:
        """Whether the folder holds the run of another scene; the machine does not count."""
        tables = [parameters(scene) for scene in (read_scene(self.folder / MADE, threads=1), self.scene)]
        return tables[0] | {"machine": None} != tables[1] | {"machine": None}

    def _went_on(self, extra: tuple) -> bool:
        """Go on from a checkpoint of this run; False if there is none of use."""
        if not self.begun:
            return False
        try:
            threads = self.scene.machine.threads
            api.resume(self.folder, threads=threads, film=self.film, progress=False, extra=extra)
        except BadInput:  # none, damaged, of another version, or without the film
            return False
        return True


def costs(runs: dict[str, Run], missing: list[str]) -> dict[str, Cost]:
    """What the missing runs will cost, at the pace of a finished one with the same formulas or of a rehearsal.

    Of several finished ones it is that whose number of points is nearest: a step of few points costs more for each.

    Starts Taichi.

    Raises BadInput if a processor cannot be used, or the memory does not suffice.
    """
    paces: dict[tuple, list[tuple[int, float]]] = {}  # points, and seconds of a point and step
    found = {}
    for run in runs.values():
        cost = run.summary.get("cost", {}) if run.finished else {}
        if cost.get("steps"):
            points = run.scene.points  # of the whole silo, as of a scene whose cost is asked
            paces.setdefault(run.formulas, []).append((points, cost["seconds"] / (points * cost["steps"])))
    for machine in {runs[name].scene.machine for name in missing}:
        machine.start()
    for name in sorted(missing, key=lambda name: runs[name].scene.points):
        scene = runs[name].scene
        if runs[name].formulas not in paces:
            memory_need.check(scene)
            scene.machine.start()
            paces[runs[name].formulas] = [(scene.points, rehearse(Simulation(scene)) / scene.points)]
        found[name] = at_pace(scene, _nearest(paces[runs[name].formulas], scene.points))
    return found


def _nearest(paces: list[tuple[int, float]], points: int) -> float:
    """The median pace of the runs whose number of points is nearest."""
    apart = [abs(math.log(max(one, 1) / points)) for one, _ in paces]
    least = min(apart)
    return statistics.median(pace for (_, pace), far in zip(paces, apart, strict=True) if far <= least + 1e-9)
