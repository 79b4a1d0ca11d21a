"""How far a sweep is, on a terminal as a bar, elsewhere as a line now and then."""

import threading

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from taichi_silo.utils.time_left import Tally

SAID_EVERY = 0.05  # of the whole, where no terminal shows a bar


class Told:
    """Tells how many runs have ended, which part of the work is done, and the time that is left.

    Parameters
    ----------
    console : where.
    tally : of the runs' parts.

    """

    def __init__(self, console: Console, tally: Tally):
        self.console, self.tally, self.ends, self.said = console, tally, set(), 0.0
        self.lock = threading.RLock()
        self.bar = Progress(
            TextColumn("{task.percentage:5.1f} %"), BarColumn(24), TextColumn("{task.description}"), console=console,
            disable=not console.is_terminal,
        )  # fmt: skip
        self.task = self.bar.add_task(self._words, total=1.0)

    def __enter__(self):
        self.bar.start()
        return self

    def __exit__(self, *_):
        self.bar.stop()

    def heard(self, name: str, part: float, pid: int = 0) -> None:
        """Of a run this part is done, in the process `pid` of a worker."""
        with self.lock:
            if name in self.ends:  # said before its end, and heard after it
                return
            share = self.tally.advance(name, part)
            self._show(share)
            if not self.console.is_terminal and share >= self.said + SAID_EVERY:
                self.said = share
                self.console.print(f"{100 * share:5.1f} %  {self._words}", markup=False)

    def ended(self, name: str, words: str) -> None:
        """A run is over."""
        with self.lock:
            self.ends.add(name)
            self.said = share = self.tally.advance(name, 1.0)
            self._show(share)
            self.console.print(f"{100 * share:5.1f} %  {self._words}  {name}: {words}", markup=False)

    def _show(self, share: float) -> None:
        self.bar.update(self.task, completed=share, description=self._words)

    @property
    def _words(self) -> str:
        return f"{len(self.ends)} of {len(self.tally.parts)} runs, {self.tally.left_s / 60:.1f} min left"
