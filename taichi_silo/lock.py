"""One process at a time: a lock on a file, which the system takes from a process that is gone."""

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

from taichi_silo.faults import BadInput

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None
    import msvcrt

ASKED_EVERY_S = 0.2


@contextlib.contextmanager
def alone(file: Path, wait_s: float, held: str) -> Iterator[None]:
    """Do something while no other process does it, on this machine or on another one of the same file system.

    Parameters
    ----------
    file : that is locked; it is there only as long.
    wait_s : how long to wait for another process.
    held : the sentence if that takes longer.

    Raises
    ------
    BadInput
        with that sentence; or if the file cannot be written.

    """
    end = time.monotonic() + wait_s
    while (handle := _taken(file)) is None:
        if time.monotonic() > end:
            raise BadInput(held)
        time.sleep(ASKED_EVERY_S)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows keeps a file that another process has opened
            file.unlink()
        os.close(handle)


def _taken(file: Path) -> int | None:
    """The locked file, opened; None if another process has it."""
    try:
        handle = os.open(file, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        if fcntl is None and isinstance(error, PermissionError):  # Windows, while it is being removed
            return None
        raise BadInput(f"output {file.parent} cannot be written: {error.strerror or error}") from error
    try:
        if fcntl is None:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(os.fstat(handle), os.stat(file)):  # not one that its last owner has just removed
            return handle
    except (BlockingIOError, PermissionError, FileNotFoundError):
        pass
    except OSError:  # a file system without locks
        return handle
    os.close(handle)
    return None
