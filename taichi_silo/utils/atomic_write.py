"""Files that outlive a crash of the program or of the machine: whole or not there, and on the disk."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from taichi_silo.utils.machine_faults import of_file


def sync(file: Path) -> None:
    """Return when a file, or what a folder lists, is on the disk."""
    if os.name == "nt" and file.is_dir():
        return  # Windows keeps its folders by itself
    handle = os.open(file, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def put(temporary: Path, file: Path, previous: Path | None = None) -> None:
    """Give a finished file its name; what had that name before gets another one, or is gone."""
    sync(temporary)
    if previous is not None and file.exists():
        file.replace(previous)
    temporary.replace(file)
    sync(file.parent)


@contextlib.contextmanager
def written(file: Path, previous: Path | None = None) -> Iterator[Path]:
    """A name to write a file under; it gets its own when that has gone well, and leaves nothing if it has not.

    Parameters
    ----------
    file : that will be there.
    previous : the name for what had that name before; it is gone if none is given.

    Raises
    ------
    OSError
        that names the file, if it cannot be written.

    """
    passing = file.with_name(f"{file.name}.part")
    try:
        yield passing
        put(passing, file, previous)
    except OSError as error:
        raise of_file(error, file) from error
    finally:
        with contextlib.suppress(OSError):
            passing.unlink(missing_ok=True)
