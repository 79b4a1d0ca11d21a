"""Runs the points of a chart, each in a process of its own, and says how far it is."""

import json
import statistics
from pathlib import Path

from taichi_silo.runs.cost_estimate import START_S, Cost, at_pace, rehearse
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils.process_pool import Processes, Task
from validation.accuracy.points import Point, kept


def pace(found: dict[str, dict], base: Point) -> float:
    """Seconds of a point and step on one core: median of the finished points, or of a rehearsal of the base.

    Taichi has been started.
    """
    costs = [run["cost"] for run in found.values()]
    if costs:
        return statistics.median(cost["core_seconds"] / (cost["points"] * max(cost["steps"], 1)) for cost in costs)
    return rehearse(Simulation(base.scene)) / base.scene.points


def expected(points: dict[str, Point], seconds: float) -> dict[str, Cost]:
    """Of each point, before it starts: its number of steps, at a pace in seconds a point and step."""
    return {key: at_pace(one.scene, seconds) for key, one in points.items()}


class Workers:
    """As many processes at a time as `jobs`; finished points are kept in `folder`, so that a restart goes on.

    `say` hears a sentence when a point starts, with its expected cost, and when it ends, with the time left.
    """

    def __init__(self, folder: Path, jobs: int, say=print):
        self.folder, self.say, self.processes = folder, say, Processes(jobs, say)

    def run(self, points: dict[str, Point], names: dict[str, str], costs: dict[str, Cost]) -> dict[str, str]:
        """Run what has no file yet, the longest first; returns why, by key, for those that left none."""
        self.folder.mkdir(parents=True, exist_ok=True)
        missing = {key: one for key, one in points.items() if kept(one, self.folder) is None}
        keys = {}
        for key in missing:  # several points may be told by one name
            keys[names[key] if names[key] not in keys else f"{names[key]} ({key})"] = key
        tasks = [
            Task(
                name=name,
                program=("validation.accuracy.points", str(self.folder)),
                line=missing[key].model_dump_json(),
                environment={"TAICHI_SILO_PRECISION": missing[key].precision},
                seconds=costs[key].core_seconds + START_S,
            )
            for name, key in keys.items()
        ]

        def ended(task: Task, trouble: str) -> str:
            run = kept(missing[keys[task.name]], self.folder)
            return trouble or f"{run['cost']['core_seconds']:.3g} core-seconds"

        troubles = self.processes.run(tasks, self._told, ended)
        return {keys[name]: why for name, why in troubles.items()}

    def _told(self, task: Task, line: str) -> float | None:
        """Hand on what a point expects to cost."""
        try:
            cost = json.loads(line)
            words = f"{cost['steps']:,} steps, about {cost['core_seconds']:.3g} core-seconds"
        except (ValueError, KeyError, TypeError):
            return None
        self.say(f"         {task.name:60s} {words}")
        return 0.0
