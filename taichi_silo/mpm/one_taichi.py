"""One Taichi a process: what would be lost if it were started, in a thread, after a fork, or over a user's own fields.

To start it anew ends all fields that there are; to read one of them then ends the process.
"""

import contextlib
import gc
import os
import threading
from collections.abc import Iterator
from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.mpm.language import program, ti

MARK = "of_taichi_silo"  # attribute of the arrays that this program makes
_lock = threading.Lock()  # of the run that Taichi works for
_holder: int | None = None  # the thread of that run
_forked = False  # whether this process was forked from one in which Taichi was running
_ours: object | None = None  # the Taichi that this program has started last,
_left: int | None = None  # and how many fields there were when the last run ended, if that was in this one
_crew: Any = None  # the `crew.Crew` whose runs Taichi works for in turns


def _in_child() -> None:
    """Take note of a fork; the thread that held the lock is not here."""
    global _forked, _lock, _holder
    _forked = _forked or _running() is not None
    _lock, _holder = threading.Lock(), None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)


def _running() -> object | None:
    """The Taichi that runs in this process."""
    return program()


def _fields() -> int:
    """How many trees of fields the running Taichi has, and fields that it has not laid out yet."""
    running = program()
    if running is None:
        return 0
    pending = len(getattr(ti.lang.impl.get_runtime(), "global_vars", ()))
    return pending + running.get_snode_tree_size()


def crew() -> Any:
    """The `crew.Crew` whose runs Taichi works for in turns; None where it works for one run."""
    return _crew if _holder == threading.get_ident() else None


@contextlib.contextmanager
def within(crew: object) -> Iterator[None]:
    """Within, Taichi works for the runs of a crew; this thread holds it."""
    global _crew
    _crew = crew
    try:
        yield
    finally:
        _crew = None


def started() -> None:
    """Take note that this program has just started Taichi."""
    global _ours, _left
    _ours, _left = _running(), None


def check() -> None:
    """Refuse to start Taichi where it cannot work, or works for a run in another thread.

    Raises
    ------
    BadInput
        with what to do instead.

    """
    if _forked:
        raise BadInput(
            f"process {os.getpid()} was forked from one in which Taichi was running, and would wait for its threads "
            'for ever; it must be started anew: multiprocessing.get_context("spawn"), or taichi-silo sweep'
        )
    if _holder not in (None, threading.get_ident()):
        raise BadInput(
            "Taichi works for a run in another thread of this process, and there is one for all threads; wait for the "
            "run to end, or use a process of its own"
        )


def _check_fields() -> None:
    """Refuse to end fields that are not of this program."""
    running, count = _running(), _fields()
    if running is None:
        return
    foreign = running is not _ours
    arrays = foreign and any(isinstance(one, ti.Ndarray) and not hasattr(one, MARK) for one in gc.get_objects())
    if (foreign and (count or arrays)) or (not foreign and _left is not None and count > _left):
        raise BadInput(
            "Taichi holds fields of your own in this process, and a run would end them: to read one later is a "
            "segmentation fault; keep what they hold with to_numpy(), call ti.reset() and begin, or run in a process "
            "of its own"
        )


@contextlib.contextmanager
def held() -> Iterator[None]:
    """Within, Taichi works for the run of this thread; that of another thread waits until it has ended.

    For the runs of a crew it does so already.

    Raises
    ------
    BadInput
        if the process was forked, a run of this thread goes on already, or fields of the user's own would be lost.

    """
    global _holder, _left
    if crew():
        yield
        return
    if _holder == threading.get_ident():
        raise BadInput("a run was begun within a run; it must wait until that has ended, or use a process of its own")
    if _forked:
        check()
    with _lock:
        _check_fields()
        _holder = threading.get_ident()
        try:
            yield
        finally:
            _holder, _left = None, _fields() if _running() is _ours else None
