"""Files that outlive a crash of the program or of the machine: whole or not there, and on the disk."""

import os
from pathlib import Path


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
