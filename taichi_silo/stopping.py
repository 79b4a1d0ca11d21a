"""Ctrl-C and the signal to end take effect between two intervals only, where clock, points and files agree."""

import contextlib
import signal
import threading

from taichi_silo.faults import Stopped


@contextlib.contextmanager
def between_intervals():
    """Within, the two only ask; gives a function to call between intervals with the sentence to say if they have.

    The function raises `Stopped`. In a thread other than the main one, which hears no signals, nothing asks.
    """
    asked = []

    def check(sentence) -> None:
        if asked:
            raise Stopped(sentence(), 128 + asked[0])

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    usual = {}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            usual[number] = signal.signal(number, lambda number, _: asked.append(number))
        yield check
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
