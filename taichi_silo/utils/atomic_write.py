"""Writing files so that a crash of the program or of the machine leaves them whole or not there at all."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from taichi_silo.utils.machine_faults import of_file


def sync(file: Path) -> None:
    """Wait until a file, or the list of a folder, is on the disk."""
    if os.name == "nt" and file.is_dir():
        return  # Windows keeps its folders by itself
    handle = os.open(file, os.O_RDONLY if os.name != "nt" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def put(temporary: Path, file: Path, previous: Path | None = None, synced: bool = True) -> None:
    """Rename a finished file to its name; a file of that name is renamed to `previous`, or replaced."""
    if synced:
        sync(temporary)
    if previous is not None and file.exists():
        file.replace(previous)
    temporary.replace(file)
    if synced:
        sync(file.parent)


@contextlib.contextmanager
def written(file: Path, previous: Path | None = None, synced: bool = True) -> Iterator[Path]:
    """A temporary name to write a file under; it is renamed at the end of the block, or removed after an error.

    A file that had the name before is renamed to `previous`, or replaced. One that need not be `synced` outlives the
    program, but not yet the machine. Raises OSError, which names the file, if it cannot be written.
    """
    passing = file.absolute().with_name(f"{file.name}.part")  # pandas reads a relative "run:1/..." as an address
    try:
        yield passing
        put(passing, file, previous, synced)
    except OSError as error:
        raise of_file(error, file) from error
    finally:
        with contextlib.suppress(OSError):
            passing.unlink(missing_ok=True)
