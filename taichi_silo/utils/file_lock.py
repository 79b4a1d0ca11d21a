"""One process at a time: a lock of the operating system on a file, which a process that is gone holds no more."""

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

from taichi_silo.errors import BadInput

NAME = ".lock"  # in the folder of a run
FAR = 1 << 20  # a byte beyond the file's end: Windows lets nobody read what is locked
ASKED_EVERY_S = 0.2


@contextlib.contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder.

    Raises
    ------
    BadInput
        if another run is in it.

    """
    busy = f"output {folder} is in use by another run (process %s); wait for it, or give another folder"
    with alone(folder / NAME, 0.0, busy):
        yield


@contextlib.contextmanager
def alone(file: Path, wait_s: float, busy: str) -> Iterator[None]:
    """Do something while no other process does it, on this machine or on another one of the same file system.

    Parameters
    ----------
    file : that is locked; it is there only as long.
    wait_s : how long to wait for another process.
    busy : the sentence if that takes longer; %s in it stands for the number of that process.

    Raises
    ------
    BadInput
        with that sentence; or if the file cannot be written.

    """
    end = time.monotonic() + wait_s
    while (stream := _taken(file)) is None:
        if time.monotonic() > end:
            raise BadInput(busy.replace("%s", _holder(file)))
        time.sleep(ASKED_EVERY_S)
    try:
        stream.truncate(0)
        stream.write(b"%d\n" % os.getpid())
        stream.flush()
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows removes no open file; one that stays holds nothing
            file.unlink()
        stream.close()


def _taken(file: Path):
    """The locked file, opened; None if another process has it."""
    try:
        stream = open(file, "a+b")  # noqa: SIM115 - its closing is the release
    except OSError as error:
        if os.name == "nt" and isinstance(error, PermissionError):  # while it is being removed
            return None
        raise BadInput(f"output {file.parent} cannot be written: {error.strerror or error}") from error
    if _lock(stream) and _is_still(file, stream):  # not one that its last holder has just removed
        return stream
    stream.close()
    return None


def _holder(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8").strip() or "unknown"
    except (OSError, UnicodeDecodeError):
        return "unknown"


def _is_still(file: Path, stream) -> bool:
    """Whether an open file is the one that has the name."""
    try:
        return os.path.samestat(file.stat(), os.fstat(stream.fileno()))
    except FileNotFoundError:
        return False


if os.name == "nt":
    import msvcrt

    def _lock(stream) -> bool:
        stream.seek(FAR)
        try:
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
else:
    import fcntl

    def _lock(stream) -> bool:
        try:
            fcntl.flock(stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            return True  # a file system that knows no locks
        return True
