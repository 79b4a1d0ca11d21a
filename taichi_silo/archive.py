"""Numbers, words and arrays in one file that knows whether it is whole.

The file is a `.npz` without pickled objects: `header` (JSON: format, version of the program, checksum), `content`
(JSON: everything that is no array) and the arrays, each under its path through the dictionaries. Floats come back bit
by bit.
"""

import hashlib
import json
from importlib.metadata import version
from pathlib import Path

import numpy as np

from taichi_silo.faults import BadInput

FORMAT = 2  # of what is kept; a file of another one is refused


class Damaged(ValueError):
    """The file is not what was written."""


def write(file: Path, tree: dict) -> None:
    """Write a tree of dictionaries; their leaves are arrays, or what JSON knows."""
    arrays = {}
    content = json.dumps(_without_arrays(tree, "", arrays), default=_plain)
    header = {"format": FORMAT, "taichi_silo": version("taichi-silo"), "sha256": _checksum(content, arrays)}
    with open(file, "wb") as stream:
        np.savez(stream, header=json.dumps(header), content=content, **arrays)


def read(file: Path) -> tuple[dict, dict]:
    """The header and the tree.

    Raises
    ------
    FileNotFoundError
        if it is not there.
    Damaged
        if it cannot be read, or is not what was written.
    BadInput
        if it is of another format.

    """
    header, content, arrays = {}, "", {}
    try:
        with np.load(file, allow_pickle=False) as stored:
            header = dict(json.loads(str(stored["header"])))
            if header.get("format") == FORMAT:
                content = str(stored["content"])
                arrays = {name: stored[name] for name in stored.files if name not in ("header", "content")}
    except FileNotFoundError:
        raise
    except Exception as error:  # noqa: BLE001 - a damaged file makes its readers say anything
        raise Damaged(f"it cannot be read: {error or type(error).__name__}") from error
    if header.get("format") != FORMAT:
        written = f"format {header['format']}" if "format" in header else "an earlier version"
        raise BadInput(f"{file} is of {written}; this version of taichi-silo goes on from format {FORMAT}")
    if _checksum(content, arrays) != header.get("sha256"):
        raise Damaged("its checksum does not fit")
    tree = json.loads(content)
    for path, values in arrays.items():
        *names, last = path.split("/")
        place = tree
        for name in names:
            place = place[name]
        place[last] = values
    return header, tree


def _without_arrays(tree: dict, path: str, arrays: dict) -> dict:
    """The tree less its arrays, which are gathered by their paths."""
    rest = {}
    for name, value in tree.items():
        if isinstance(value, np.ndarray):
            arrays[path + name] = value
        else:
            rest[name] = _without_arrays(value, f"{path}{name}/", arrays) if isinstance(value, dict) else value
    return rest


def _plain(value):
    """A number of numpy's as Python's."""
    return value.item()


def _checksum(content: str, arrays: dict) -> str:
    found = hashlib.sha256(content.encode())
    for name in sorted(arrays):
        values = arrays[name]
        found.update(f"{name} {values.dtype.str} {values.shape}".encode())
        found.update(values.tobytes())
    return found.hexdigest()
