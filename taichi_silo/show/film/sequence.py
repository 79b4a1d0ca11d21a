"""Frames to a folder of numbered pictures, for programs that cut films."""

import re
import shutil
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image

from taichi_silo.errors import BadInput
from taichi_silo.utils.machine_faults import of_file

NUMBERED = re.compile(r"\d{5,}\.png")  # 00001.png, 00002.png, ...


def write_sequence(folder: Path, frames: Iterable[np.ndarray]) -> int:
    """Write frames (rows, columns, 3 or 4) of bytes as PNG; returns how many there were.

    The folder is there when it is complete, or not at all; one that is there is replaced.
    """
    passing, count = passing_folder(folder), 0
    try:
        shutil.rmtree(passing, ignore_errors=True)
        passing.mkdir(parents=True)
        for frame in frames:
            count += 1
            Image.fromarray(frame).save(passing / f"{count:05d}.png", compress_level=4)
        if folder.exists():
            shutil.rmtree(folder)
        passing.replace(folder)
    except OSError as error:
        raise of_file(error, folder) from error
    finally:
        shutil.rmtree(passing, ignore_errors=True)
    return count


def passing_folder(folder: Path) -> Path:
    """The name of a sequence that is not complete."""
    return folder.with_name(f"{folder.name}.part")


def need_sequence(folder: Path) -> None:
    """Refuse to replace what is no folder of numbered pictures.

    Raises
    ------
    BadInput
        with the first thing in it that is none.

    """
    strange = [file.name for file in sorted(folder.iterdir()) if not NUMBERED.fullmatch(file.name)]
    if strange:
        raise BadInput(f"output {folder} holds {strange[0]}; it must be a new folder, or one of numbered pictures only")
