"""One attempt to bring a run to its end."""

from taichi_silo.batch.runs import Run
from taichi_silo.lock import alone
from taichi_silo.run import run as from_the_start

LOCK = ".running"  # in the folder of a run
WAIT_S = 600.0  # for the process of an earlier attempt, whose worker is gone, to put its files in order


def attempt(wanted: Run, extra: tuple = ()) -> None:
    """Do what is left to be done: nothing if another attempt has finished it by now, else all.

    This is the one place that decides about what an earlier attempt left. No two processes attempt a run at once.

    Parameters
    ----------
    wanted : the run.
    extra : further observers.

    Raises
    ------
    BadInput
        if the folder cannot be written, or another process does not let go of it.
    RunFailed
        if the run went wrong.

    """
    held = f"output {wanted.folder} is being written by another process"
    wanted.folder.mkdir(parents=True, exist_ok=True)
    with alone(wanted.folder / LOCK, WAIT_S, held):
        if not wanted.finished:
            from_the_start(wanted.scene, wanted.folder, overwrite=True, film=wanted.film, extra=extra)
