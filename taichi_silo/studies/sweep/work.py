"""What a worker does: one run, in a process of its own, so that Taichi is fresh and a crash kills no worker.

Whoever leads the sweep hears how far a run is as an event of the topic `sweep`, which is the sweep's own.
"""

import contextlib
import json
import os
import threading
import time
from pathlib import Path

from distributed import get_worker

from taichi_silo.studies.sweep.runs import PROGRAM, part
from taichi_silo.utils.child_process import Child

SAID_EVERY_S = 1.0
STOPPED = "stopped"
_children: dict[str, set[Child]] = {}  # of this process, by sweep
_stopped: set[str] = set()  # sweeps
_lock = threading.Lock()  # a run begins either before its sweep is stopped, or not at all


class Crashed(Exception):
    """A run's process ended by no will of its own: worth another try."""


def work(name: str, order: str, sweep: str, program: tuple[str, ...] = PROGRAM) -> str:
    """Do a run.

    Parameters
    ----------
    name : of the run.
    order : what its program is given (`Run.order`).
    sweep : topic of its events.
    program : that makes it.

    Returns
    -------
    Why it failed, in a sentence; empty if it did not.

    Raises
    ------
    Crashed
        if it neither did what it was told nor said why not.

    """
    worker, heard = get_worker(), 0.0
    output = Path(json.loads(order)["folder"]).parent
    if not output.is_dir():
        return f"output {output} is not there on {worker.name}; it must be on a file system that all workers share"
    with _lock:
        if sweep in _stopped:
            return STOPPED
        child = Child(program, order)
        _children.setdefault(sweep, set()).add(child)
    try:
        worker.log_event(sweep, {"run": name, "part": 0.0, "pid": os.getpid()})
        for line in child.lines():
            done = part(line)
            if done is None:
                child.keep(line)
            elif time.monotonic() > heard + SAID_EVERY_S:
                heard = time.monotonic()
                worker.log_event(sweep, {"run": name, "part": done, "pid": os.getpid()})
    finally:
        with _lock:
            _children[sweep].discard(child)
    if child.crashed:
        raise Crashed(child.trouble)
    return child.trouble


def stop(sweep: str) -> int:
    """Ask all runs of a sweep in this process to stop, now and later; returns how many there still are."""
    with _lock:
        _stopped.add(sweep)
        children = list(_children.get(sweep, ()))
    for child in children:
        with contextlib.suppress(OSError):
            child.interrupt()
    return len(children)
