"""One attempt to bring a run to its end."""

from taichi_silo.errors import BadInput
from taichi_silo.runs.session import resume
from taichi_silo.runs.session import run as from_the_start
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.utils.file_lock import alone

LOCK = ".running"  # in the folder of a run
WAIT_S = 600.0  # for the process of an earlier attempt, whose worker is gone, to put its files in order


def attempt(wanted: Run, extra: tuple = ()) -> None:
    """Do what is left: nothing if another attempt has finished it by now, the rest if one has begun it, or all.

    This is the one place that decides about what an earlier attempt left. No two processes attempt a run at once.

    Parameters
    ----------
    wanted : the run.
    extra : further observers.

    Raises
    ------
    BadInput
        if the folder cannot be written, or another process does not let go of it.
    RunFailed, Stopped
        as `one_run.run`.

    """
    held = f"output {wanted.folder} is being written by another process"
    wanted.folder.mkdir(parents=True, exist_ok=True)
    with alone(wanted.folder / LOCK, WAIT_S, held):
        if not wanted.finished and not _went_on(wanted, extra):
            from_the_start(wanted.scene, wanted.folder, overwrite=True, film=wanted.film, extra=extra)


def _went_on(wanted: Run, extra: tuple) -> bool:
    """Go on from a checkpoint of this run; False if there is none of use."""
    if not wanted.begun:
        return False
    try:
        resume(wanted.folder, threads=wanted.scene.machine.threads, film=wanted.film, extra=extra)
    except BadInput:  # none, damaged, of another version, or without the film
        return False
    return True
