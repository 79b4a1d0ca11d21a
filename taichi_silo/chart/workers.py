"""Runs the points of a chart, each in a process of its own, and says how far it is."""

import contextlib
import json
import os
import statistics
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from taichi_silo.chart.points import Point, kept
from taichi_silo.cost import Cost, rehearse, steps
from taichi_silo.simulation import Simulation

START_S = 6.0  # of a process: Taichi's start and the compilation of the step


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
    return {
        key: Cost(one.scene.points, count := steps(one.scene), seconds * one.scene.points * count)
        for key, one in points.items()
    }


class Workers:
    """As many processes at a time as `jobs`; finished points are kept in `folder`, so that a restart goes on.

    `say` hears a sentence when a point starts, with its expected cost, and when it ends, with the time left.
    """

    def __init__(self, folder: Path, jobs: int, say=print):
        self.folder, self.jobs, self.say = folder, jobs, say
        self.children, self.lock, self.stopped = set(), threading.Lock(), False

    def run(self, points: dict[str, Point], names: dict[str, str], costs: dict[str, Cost]) -> dict[str, str]:
        """Run what has no file yet, the longest first; returns why, by key, for those that left none."""
        self.folder.mkdir(parents=True, exist_ok=True)
        missing = [key for key, one in points.items() if kept(one, self.folder) is None]
        missing.sort(key=lambda key: -costs[key].core_seconds)
        whole = sum(costs[key].core_seconds + START_S for key in missing)
        begun, done, lost = time.monotonic(), 0.0, {}
        workers = ThreadPoolExecutor(self.jobs)
        jobs = {workers.submit(self._one, points[key], names[key]): key for key in missing}
        try:
            for job in as_completed(jobs):
                key = jobs[job]
                done += costs[key].core_seconds + START_S
                left = (time.monotonic() - begun) * (whole - done) / done
                trouble = job.result()
                if trouble:
                    lost[key] = trouble
                seconds = (kept(points[key], self.folder) or {}).get("cost", {}).get("core_seconds")
                word = trouble or f"{seconds:.3g} core-seconds"
                self.say(f"{100 * done / whole:5.1f} %  {names[key]:60s} {word:24s} {left / 60:5.1f} min left")
        except BaseException:
            self._stop()
            raise
        finally:
            workers.shutdown(wait=True, cancel_futures=True)
        return lost

    def _one(self, one: Point, name: str) -> str:
        """Run a point; returns why it left no file, or nothing."""
        command = [sys.executable, "-m", "taichi_silo.chart.points", str(self.folder)]
        with self.lock:
            if self.stopped:
                return "stopped"
            child = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                env=os.environ | {"TAICHI_SILO_PRECISION": one.precision},
            )  # fmt: skip
            self.children.add(child)
        output, errors = self._talk(child, one, name)
        with self.lock:
            self.children.discard(child)
        if child.returncode == 0:
            return ""
        lines = (errors or output).strip().splitlines()
        return lines[-1] if lines else f"ended with code {child.returncode}"

    def _talk(self, child, one: Point, name: str) -> tuple[str, str]:
        """Give the child its point, and hand on what it expects to cost."""
        with contextlib.suppress(BrokenPipeError):  # it ended at once, and says why
            child.stdin.write(one.model_dump_json() + "\n")
            child.stdin.close()
        rest = []
        for line in child.stdout:
            try:
                cost = json.loads(line)
                self.say(f"         {name:60s} {cost['steps']:,} steps, about {cost['core_seconds']:.3g} core-seconds")
            except (ValueError, KeyError, TypeError):
                rest.append(line)
        errors = child.stderr.read()
        child.wait()
        return "".join(rest), errors

    def _stop(self) -> None:
        with self.lock:
            self.stopped = True
            for child in self.children:
                child.terminate()
