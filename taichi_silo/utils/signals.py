"""Ctrl-C and SIGTERM stop a run between two intervals, where clock, points and files agree.

Before the first interval, and while figures are drawn, they take effect at once.
"""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator

from taichi_silo.errors import Stopped

BEFORE = "stopped before the run had begun; there is nothing of it to go on from"


class Stops:
    """Signals that have come, and whether they take effect at once."""

    def __init__(self, asked: list[int] | None = None) -> None:
        self.asked = [] if asked is None else asked  # numbers of the signals that have come
        self.heeded = 0  # how many of them have stopped something
        self.sentence: str | None = None  # what to say when a signal takes effect at once; None while signals wait

    def hear(self, number: int, frame=None) -> None:
        """Note a signal; the handler of SIGINT and SIGTERM."""
        self.asked.append(number)
        if self.sentence is not None:
            self._stop(self.sentence)

    def check(self, sentence: Callable[[], str]) -> None:
        """Raise `Stopped` with a sentence if a signal has come that has stopped nothing yet."""
        if len(self.asked) > self.heeded:
            self._stop(sentence())

    @contextlib.contextmanager
    def at_once(self, sentence: str) -> Iterator[None]:
        """Within this block a signal raises `Stopped` at once, also one that has come before and waits."""
        self.check(lambda: sentence)
        self.sentence = sentence
        try:
            yield
        finally:
            self.sentence = None

    def _stop(self, sentence: str) -> None:
        self.heeded, self.sentence = len(self.asked), None  # a second one must not cut off what the first one lets end
        raise Stopped(sentence, 128 + self.asked[0])


_first: Stops | None = None  # what hears the signals now
times = 0  # how often a block has begun to hear them, which runs do first of all


@contextlib.contextmanager
def heard() -> Iterator[Stops]:
    """Within this block SIGINT and SIGTERM are noted; in a thread other than the main one none can be.

    A block within another one, or begun while another goes on, hears what that one hears.
    """
    global _first, times
    times += 1
    if threading.current_thread() is not threading.main_thread():
        yield Stops()
        return
    if _first is not None:
        yield Stops(_first.asked)
        return
    stops = _first = Stops()
    usual = {}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            usual[number] = signal.signal(number, stops.hear)
        yield stops
    finally:
        _first = None
        for number, handler in usual.items():
            signal.signal(number, handler)
