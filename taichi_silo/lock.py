"""One run at a time in a folder.

The lock is the operating system's, on the file `.lock`: whoever holds it loses it with its death, however that comes.
"""

import contextlib
import os
from pathlib import Path

from taichi_silo.faults import BadInput

NAME = ".lock"
FAR = 1 << 20  # a byte beyond the file's end: Windows lets nobody read what is locked


@contextlib.contextmanager
def held(folder: Path):
    """Keep others out of a folder.

    Raises
    ------
    BadInput
        if another run is in it.

    """
    file = folder / NAME
    while True:
        stream = open(file, "a+b")  # noqa: SIM115 - its closing is the release
        if not _lock(stream):
            stream.seek(0)
            holder = stream.read().decode(errors="replace").strip() or "unknown"
            stream.close()
            raise BadInput(
                f"output {folder} is in use by another run (process {holder}); wait for it, or give another folder"
            )
        if _is_still(file, stream):
            break
        stream.close()  # its holder has just gone, and the file with it
    try:
        stream.truncate(0)
        stream.write(b"%d\n" % os.getpid())
        stream.flush()
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows removes no open file; one that stays holds nothing
            file.unlink()
        stream.close()


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
