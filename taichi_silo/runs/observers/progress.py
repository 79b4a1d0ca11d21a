"""The progress line."""

import contextlib
import sys
import time
from collections.abc import Callable

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from taichi_silo.mpm import runtime
from taichi_silo.runs.cost_estimate import clock, predict
from taichi_silo.runs.inclined_walls import none_vertical, of_which, shown_forces
from taichi_silo.runs.observers import Observer

LINE_EVERY = 0.1  # of the run, where no terminal shows a moving line
SOON_S = 5.0  # after which it shows that the run goes on, once, if a tenth takes longer
SMOOTHING = 0.05  # of the forces shown


class ProgressLine(Observer):
    """Percentage, simulated and remaining time, and the present P, T, N.

    Parameters
    ----------
    console : where to; stdout, or stderr if nobody reads that.
    permission : called before the run with the seconds that it will take; it may raise Stopped. None: nobody asks.

    """

    def __init__(self, console: Console | None = None, permission: Callable[[float], None] | None = None):
        self.console, self.permission = console or Console(stderr=not sys.stdout.isatty()), permission

    def prepare(self, simulation) -> None:
        """Say what it will cost, and ask for permission; where nothing is said, that is not found out either."""
        if self.console.quiet and self.permission is None:
            return
        self._print(simulation.model.about_averaging, highlight=False, soft_wrap=True)
        if not runtime.is_cpu():
            self._print(f"Steps run on {runtime.device()}.", highlight=False, soft_wrap=True)
        cost = predict(simulation)
        self._print(cost.words(), highlight=False, soft_wrap=True)
        if self.permission is not None:
            self.permission(cost.seconds)

    def begin(self, simulation) -> None:
        """Estimate the whole in simulated seconds."""
        self._start(simulation)
        self._show_bar()

    def restore(self, simulation, kept: dict) -> None:
        """Say from where the run goes on."""
        self._start(simulation)
        self._print(
            f"Going on from t = {simulation.time:.4f} s ({simulation.stage}), u = {1e3 * simulation.displacement:.3f} "
            "mm", highlight=False, soft_wrap=True,
        )  # fmt: skip
        self._show_bar()

    def _start(self, simulation) -> None:
        self.simulation, self.told = simulation, 0
        self.total = simulation.model.filling_time + 5.0 * simulation.model.period + simulation.model.flow_time
        self.done = min(simulation.time / self.total, 1.0)  # before this process
        self.printed, self.text, self.spoke = self.done, "", False
        self.forces: tuple[float, ...] | None = None
        self.bar: Progress | None = None
        if none_vertical(simulation.scene.silo):
            self._print(f"{of_which(simulation.scene.silo)}.", highlight=False, soft_wrap=True)
        self._warn()

    def _show_bar(self) -> None:
        self.begun = time.monotonic()
        if self.console.is_terminal:
            self.bar = Progress(
                TextColumn("{task.percentage:5.1f} %"), BarColumn(24), TextColumn("{task.description}"),
                console=self.console,
            )  # fmt: skip
            self.task = self.bar.add_task("compiling", total=1.0)
            self.bar.start()

    def observe(self, record) -> None:
        """Show the present state, and what has been noticed."""
        self._warn()
        now = tuple(shown_forces(self.simulation.scene.silo, record.forces).values())
        before = self.forces or now
        self.forces = tuple(old + SMOOTHING * (new - old) for old, new in zip(before, now, strict=True))
        part = min(record.time_s / self.total, 1.0)
        left = (time.monotonic() - self.begun) * (1.0 - part) / max(part - self.done, 1e-9)
        p, t, n = (force / 1e3 for force in self.forces)
        text = (
            f"{record.stage:7s} t = {record.time_s:7.3f} s  u = {1e3 * record.displacement_m:6.2f} mm  "
            f"{clock(left)} left  P {p:.3f}  T {t:.3f}  N {n:.3f} kN/m"
        )
        self.text = text
        if self.bar is not None:
            self.bar.update(self.task, completed=part, description=text)
        elif part >= self.printed + LINE_EVERY or (not self.spoke and time.monotonic() > self.begun + SOON_S):
            self.printed, self.spoke = part, True
            self._print(f"{100 * part:5.1f} %  {text}", highlight=False, soft_wrap=True)

    def _print(self, words: str, **how) -> None:
        """A terminal that is gone must not end the run."""
        with contextlib.suppress(OSError):
            self.console.print(words, **how)

    def _warn(self) -> None:
        for sentence in self.simulation.warnings[self.told :]:
            self._print(f"Warning: {sentence}", highlight=False, soft_wrap=True)
        self.told = len(self.simulation.warnings)

    def end(self) -> None:
        """Leave the last state on the screen, and what was noticed at the end of the flow."""
        if self.bar is not None:
            self.bar.refresh()
            self.bar.stop()
        elif self.text:
            self._print(f"   end   {self.text}", highlight=False, soft_wrap=True)
        self._warn()
