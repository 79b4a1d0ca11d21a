"""How far a work of many tasks is, and the time that is left: a bar on a terminal, elsewhere a line now and then."""

import threading
import time

from rich.console import Console as RichConsole
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar

from taichi_silo.utils.messages import counted

SAID_EVERY = 0.05  # of the whole, where no terminal shows a bar


class Progress:
    """Share of the work that is done, each task weighted by its expected seconds on one core; many threads may tell it.

    `jobs` tasks run at a time.
    """

    def __init__(self, terminal: RichConsole, seconds: dict[str, float], jobs: int = 1):
        self.terminal, self.seconds, self.jobs = terminal, seconds, jobs
        self.parts, self.ends, self.said = dict.fromkeys(seconds, 0.0), set[str](), 0.0
        self.whole, self.begun = max(sum(seconds.values()), 1e-9), time.monotonic()
        self.lock = threading.RLock()
        columns = TextColumn("{task.percentage:5.1f} %"), BarColumn(24), TextColumn("{task.description}")
        self.bar = Bar(*columns, console=terminal, disable=not terminal.is_terminal)
        self.task = self.bar.add_task(self._words, total=1.0)

    def __enter__(self):
        self.bar.start()
        return self

    def __exit__(self, *_):
        self.bar.stop()

    def heard(self, name: str, part: float) -> None:
        """Take in which part of a task is done: 0 to 1, less than before if it was begun again."""
        with self.lock:
            if name in self.ends:  # said before its end, and heard after it
                return
            self._advance(name, part)
            if not self.terminal.is_terminal and self.share >= self.said + SAID_EVERY:
                self._say("")

    def ended(self, name: str, words: str) -> None:
        """A task is over; the words say how it went."""
        with self.lock:
            self.ends.add(name)
            self._advance(name, 1.0)
            self._say(f"  {name}: {words}")

    @property
    def share(self) -> float:
        """Of the whole that is done."""
        return sum(part * self.seconds[name] for name, part in self.parts.items()) / self.whole

    @property
    def left_s(self) -> float:
        """Seconds until the end: at the pace so far, and no less than the longest task still needs at that pace."""
        rest = [(1.0 - part) * self.seconds[name] for name, part in self.parts.items()] or [0.0]
        passed, done = time.monotonic() - self.begun, self.whole - sum(rest)
        if done <= 0.0:
            return max(sum(rest) / self.jobs, max(rest))
        slowness = min(self.jobs, len(rest)) * passed / done  # of a core, against what was expected
        return max(passed / done * sum(rest), slowness * max(rest))

    def _advance(self, name: str, part: float) -> None:
        self.parts[name] = part
        self.bar.update(self.task, completed=self.share, description=self._words)

    def _say(self, words: str) -> None:
        self.said = self.share
        self.terminal.print(f"{100 * self.share:5.1f} %  {self._words}{words}", markup=False)

    @property
    def _words(self) -> str:
        return f"{len(self.ends)} of {counted(len(self.parts), 'run')}, {self.left_s / 60:.1f} min left"
