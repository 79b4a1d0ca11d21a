"""How a command speaks: for a person, for nobody, or for a script that reads JSON."""

import contextlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from taichi_silo.utils import streams

if TYPE_CHECKING:  # nothing is imported for a command that says nothing
    from rich.console import Console as RichConsole
    from rich.progress import Progress

T = TypeVar("T")
WIDE = 132  # columns of a table that goes to a file or another program


@dataclass(frozen=True)
class Console:
    """What is printed where."""

    quiet: bool = False  # print errors only
    as_json: bool = False  # stdout is kept for one JSON object, the result

    @property
    def terminal(self) -> "RichConsole":
        """For lines, tables and progress bars; silent where nothing is to be said."""
        from rich.console import Console as RichConsole

        stream = sys.stderr if self.as_json else sys.stdout
        width = None if stream.isatty() else WIDE
        return RichConsole(file=stream, quiet=self.quiet, highlight=False, soft_wrap=True, width=width)

    def progress(self) -> "Progress":
        """A progress bar that vanishes at its end; it is drawn on a terminal only."""
        from rich.progress import Progress

        terminal = self.terminal
        return Progress(console=terminal, transient=True, disable=self.quiet or not terminal.is_terminal)

    @contextlib.contextmanager
    def status(self, words: str) -> Iterator[Callable[[str], None]]:
        """A line that says how far a work is, and vanishes at its end; it takes new words, on a terminal only."""
        terminal = self.terminal
        if self.quiet or not terminal.is_terminal:
            yield lambda words: None
            return
        with terminal.status(words) as line:
            yield line.update

    def tracked(self, steps: Iterable[T], words: str) -> Iterable[T]:
        """The steps of a work, with a progress bar while they are gone through."""
        from rich.progress import track

        terminal = self.terminal
        silent = self.quiet or not terminal.is_terminal
        return track(steps, words, console=terminal, transient=True, disable=silent)  # type: ignore[arg-type]

    def say(self, *lines: str) -> None:
        """Tell a person."""
        for line in lines:
            self.terminal.print(line, markup=False)

    def result(self, found: dict) -> None:
        """Tell a script, if one listens."""
        if self.as_json:
            json.dump(found, sys.stdout, default=str, allow_nan=False)
            print()
            streams.heard()
