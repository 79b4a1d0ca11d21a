"""The progress line."""

import contextlib
import sys
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from taichi_silo.mpm import runtime
from taichi_silo.runs.cost_estimate import predict
from taichi_silo.runs.observers import Observer

LINE_EVERY = 0.1  # of the run, where no terminal shows a moving line
SMOOTHING = 0.05  # of the forces shown


class ProgressLine(Observer):
    """Percentage, simulated and remaining time, and the present P, T, N."""

    def __init__(self, console: Console | None = None):
        self.console = console or Console(stderr=not sys.stdout.isatty())

    def begin(self, simulation) -> None:
        """Say what it will cost, and estimate the whole in simulated seconds."""
        self._print(simulation.model.about_averaging, highlight=False, soft_wrap=True)
        self._start(simulation)
        if not runtime.is_cpu():
            self._print(f"Steps run on {runtime.device()}.", highlight=False, soft_wrap=True)
        cost = predict(simulation)
        seconds = cost.core_seconds / runtime.threads()
        self._print(
            f"{cost.points:,} points, about {cost.steps:,} steps: some {_clock(seconds)} minutes of stepping",
            highlight=False, soft_wrap=True,
        )  # fmt: skip
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
        self.printed, self.text = self.done, ""
        self.forces: tuple[float, ...] | None = None
        self.bar: Progress | None = None
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
        now = (record.bottom_force_N_per_m, record.shear_N_per_m, record.normal_N_per_m)
        before = self.forces or now
        self.forces = tuple(old + SMOOTHING * (new - old) for old, new in zip(before, now, strict=True))
        part = min(record.time_s / self.total, 1.0)
        left = (time.monotonic() - self.begun) * (1.0 - part) / max(part - self.done, 1e-9)
        p, t, n = (force / 1e3 for force in self.forces)
        text = (
            f"{record.stage:7s} t = {record.time_s:7.3f} s  u = {1e3 * record.displacement_m:6.2f} mm  "
            f"{_clock(left)} left  P {p:.3f}  T {t:.3f}  N {n:.3f} kN/m"
        )
        self.text = text
        if self.bar is not None:
            self.bar.update(self.task, completed=part, description=text)
        elif part >= self.printed + LINE_EVERY:
            self.printed = part
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
        """Leave the last state on the screen."""
        if self.bar is not None:
            self.bar.refresh()
            self.bar.stop()
        elif self.text:
            self._print(f"   end   {self.text}", highlight=False, soft_wrap=True)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes:d}:{rest:02d}"
