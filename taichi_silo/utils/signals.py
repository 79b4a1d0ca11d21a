"""Ctrl-C and the signal to end take effect where clock, points and files agree: between two intervals of a run.

Before a run has anything to lose, and while its figures are drawn, they take effect at once.
"""

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator

from taichi_silo.errors import Stopped


class Stops:
    """What was asked for, and where it takes effect."""

    def __init__(self):
        self.asked, self.heeded, self.sentence = [], 0, None

    def hear(self, number: int, frame=None) -> None:
        """A signal has come."""
        self.asked.append(number)
        if self.sentence is not None:
            self._stop(self.sentence)

    def check(self, sentence: Callable[[], str]) -> None:
        """Raise `Stopped` with a sentence if the run was asked to stop since it was last heeded."""
        if len(self.asked) > self.heeded:
            self._stop(sentence())

    @contextlib.contextmanager
    def at_once(self, sentence: str) -> Iterator[None]:
        """Within, stop without waiting for anything, also for what was asked before and not heeded yet."""
        self.check(lambda: sentence)
        self.sentence = sentence
        try:
            yield
        finally:
            self.sentence = None

    def _stop(self, sentence: str) -> None:
        self.heeded, self.sentence = len(self.asked), None  # a second one must not cut off what the first one lets end
        raise Stopped(sentence, 128 + self.asked[0])


@contextlib.contextmanager
def heard() -> Iterator[Stops]:
    """Within, the two only ask. In a thread other than the main one, which hears no signals, nothing asks."""
    stops = Stops()
    if threading.current_thread() is not threading.main_thread():
        yield stops
        return
    usual = {}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            usual[number] = signal.signal(number, stops.hear)
        yield stops
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
