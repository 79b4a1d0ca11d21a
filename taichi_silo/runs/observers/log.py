"""What happened in a run and when, in words: `run.log`, for those who were not there."""

import contextlib
import platform
import time
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from taichi_silo.mpm import language, runtime
from taichi_silo.runs.inclined_walls import none_vertical, of_which, shown_forces
from taichi_silo.runs.observers import Observer
from taichi_silo.utils.messages import counted

PART = 0.1  # of the simulated time between two lines on how far it is
ENDED = {
    "empty": "the silo is empty", "enough": "as much as was asked for has flowed out",
    "time": "the longest time is over", "rest": "the sand has come to rest", "jam": "the flow has jammed",
}  # fmt: skip
SOON_S = 5.0  # by the clock, after which the first of them comes at the latest


class Log(Observer):
    """A line for the start, the filling, each tenth of the way, each warning and alarm, and the end.

    Lines begin with the wall clock (UTC) and the simulated time; a run that goes on adds to those that are there.
    """

    def __init__(self, file: Path):
        self.file = file
        self.failure: str | None = None

    def begin(self, simulation) -> None:
        """Say what begins."""
        self.simulation, self.told, self.part = simulation, 0, 0.0
        self.begun, self.spoke = time.monotonic(), False
        self.total = simulation.model.filling_time + 5.0 * simulation.model.period + simulation.model.flow_time
        scene = simulation.scene
        self.stream = open(self.file, "a", buffering=1, encoding="utf-8")  # noqa: SIM115 - see end()
        self.say(
            f"begins: taichi-silo {version('taichi-silo')}, {language.VERSION}, Python "
            f"{platform.python_version()}, {platform.machine()}; {counted(scene.points, 'point')}, {runtime.device()}, "
            f"{counted(runtime.threads(), 'thread')}"
        )
        if none_vertical(scene.silo):
            self.say(of_which(scene.silo))
        self._tell()

    def restore(self, simulation, kept: dict) -> None:
        """Say from where it goes on."""
        self.begin(simulation)
        self.say(f"goes on ({simulation.stage}, u = {1e3 * simulation.displacement:.3f} mm)")
        self.part = simulation.time / self.total

    def say(self, words: str) -> None:
        """Write a line; words that have several get one. A log that finds no room ends no run."""
        now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S")
        with contextlib.suppress(OSError):
            self.stream.write(f"{now}  t = {self.simulation.time:8.4f} s  {' '.join(words.split())}\n")

    def filled(self) -> None:
        """Say so."""
        rest = "at rest" if self.simulation.clock.settled else "not yet at rest"
        self.say(f"filled, {rest}")

    def observe(self, record) -> None:
        """Write what is new."""
        self._tell()
        part = record.time_s / self.total
        if part >= self.part + PART or (not self.spoke and time.monotonic() > self.begun + SOON_S):
            self.part, self.spoke = part, True
            p, t, n = (value / 1e3 for value in shown_forces(self.simulation.scene.silo, record.forces).values())
            self.say(
                f"{record.stage}, {100 * min(part, 1.0):.0f} %: u = {1e3 * record.displacement_m:.3f} mm, "
                f"P {p:.4g}, T {t:.4g}, N {n:.4g} kN/m, step {1e6 * record.time_step_s:.1f} us"
            )

    def _tell(self) -> None:
        for sentence in self.simulation.warnings[self.told :]:
            self.say(f"warning: {sentence}")
        self.told = len(self.simulation.warnings)

    def _left(self) -> str:
        """Why a free outflow has ended, and what is left in the silo."""
        simulation = self.simulation
        if not simulation.clock.ended:
            return ""
        left = simulation.above_opening / simulation.model.mass
        return f": {ENDED[simulation.clock.ended]}; {left:.1%} of the sand is in the silo"

    def failed(self, why: str) -> None:
        """Keep why for the last line."""
        self.failure = why

    def end(self) -> None:
        """Say how it ended."""
        self._tell()
        for alarm in self.simulation.alarms.found.values():
            times = f"{alarm.times} times, the last at t = {alarm.last_time_s:.4f} s: {alarm.sentence}"
            self.say(f"alarm: {alarm.name}, {'which stops the run' if alarm.stops else times}")
        self.say(f"ends{self._left()}" if self.failure is None else f"ends before its time: {self.failure}")
        with contextlib.suppress(OSError):
            self.stream.close()
