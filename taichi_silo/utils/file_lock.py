"""One process at a time in a folder: a lock of the operating system, which a process that is gone holds no more."""

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

from filelock import FileLock, Timeout

from taichi_silo.errors import BadInput

NAME = ".lock"  # in the folder of a run
ASKED_EVERY_S = 0.2
NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP)  # of a file system, often a network's, that has none


@contextlib.contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder.

    Raises BadInput if another run is in it.
    """
    busy = f"output {folder} is in use by another run (process %s); wait for it, or give another folder"
    with alone(folder / NAME, 0.0, busy):
        yield


@contextlib.contextmanager
def alone(file: Path, wait_s: float, busy: str) -> Iterator[None]:
    """Do something while no other process does it, on this machine or on another one of the same file system.

    Raises BadInput with that sentence; or if the file cannot be written.

    Parameters
    ----------
    file : that is locked, and removed at the end; it holds the number of the process.
    wait_s : how long to wait for another process.
    busy : the sentence if that takes longer; %s in it stands for the number of that process.

    """
    lock = FileLock(file, timeout=wait_s, poll_interval=ASKED_EVERY_S)
    try:
        os.stat(file.parent)  # the library would make the folder
        lock.acquire()
    except Timeout:
        raise BadInput(busy.replace("%s", _holder(file))) from None
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise BadInput(f"output {file.parent} cannot be written: {error.strerror or error}") from error
    try:
        with contextlib.suppress(PermissionError):  # Windows: what is locked cannot be written
            file.write_text(f"{os.getpid()}\n", encoding="utf-8")
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows removes no open file; one that stays holds nothing
            file.unlink()
        lock.release()


def _holder(file: Path) -> str:
    """Number of the process that has locked a file."""
    try:
        return file.read_text(encoding="utf-8").strip() or "unknown"
    except (OSError, UnicodeDecodeError):
        return "unknown"
