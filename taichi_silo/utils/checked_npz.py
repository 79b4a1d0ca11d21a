"""Numbers, words and arrays in one file with a checksum, so that a damaged one is noticed.

The file is a `.npz` without pickled objects: `header` (JSON: format, version of the program, checksum), `content`
(JSON: everything that is no array) and the arrays, each under its path through the dictionaries. Floats come back bit
by bit.
"""

import hashlib
import json
import zipfile
from importlib.metadata import version
from pathlib import Path

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import shown
from taichi_silo.utils.set_aside import is_array

ROWS = 1 << 16  # of an array that are read at once
FORMAT = 2  # of what is kept; a file of another one is refused


class Damaged(ValueError):
    """The file is not what was written."""


def write(file: Path, tree: dict) -> None:
    """Write a tree of dictionaries; their leaves are arrays, in memory or `InFile`, or what JSON knows."""
    arrays: dict = {}
    content = json.dumps(_without_arrays(tree, "", arrays), default=_plain)
    header = {"format": FORMAT, "taichi_silo": version("taichi-silo"), "sha256": _checksum(content, arrays)}
    with open(file, "wb") as stream:
        np.savez(stream, header=json.dumps(header), content=content, **arrays)  # type: ignore[arg-type]


def read(file: Path) -> tuple[dict, dict]:
    """The header and the tree.

    Raises FileNotFoundError if it is not there; Damaged if it cannot be read, or is not what was written; BadInput if
    it is of another format.
    """
    file = Path(file)
    size = file.stat().st_size
    try:
        if not file.is_file():
            raise Damaged("it is no file")
        with zipfile.ZipFile(file) as stored:
            members = stored.infolist()
            if (
                any(one.compress_type != zipfile.ZIP_STORED for one in members)
                or sum(m.file_size for m in members) > size
            ):
                raise Damaged("it promises more than it holds")
        with np.load(file, allow_pickle=False) as stored:
            header = dict(json.loads(str(stored["header"])))
            if header.get("format") != FORMAT:
                raise BadInput(_of_other_format(file, header))
            content = str(stored["content"])
            arrays = {name: stored[name] for name in stored.files if name not in ("header", "content")}
        if _checksum(content, arrays) != header.get("sha256"):
            raise Damaged("its checksum does not fit")
        return header, _whole(json.loads(content), arrays)
    except (BadInput, Damaged):
        raise
    except Exception as error:  # noqa: BLE001 - a damaged file makes its readers say anything
        raise Damaged(f"it cannot be read: {error or type(error).__name__}") from error


def understood(folder: Path):
    """Turn any error in this block, which uses a checkpoint, into BadInput: the checkpoint holds what no run keeps."""
    return bounded_reading.sense(f"{folder} cannot be resumed: its checkpoint holds what no run keeps")


def need(tree: dict, *paths: str) -> None:
    """Check that a tree has something at each of these dotted paths.

    Raises LookupError, TypeError at the first of them.
    """
    for path in paths:
        here = tree
        for name in path.split("."):
            here = here[name]


def _of_other_format(file: Path, header: dict) -> str:
    written = f"format {shown(header['format'])}" if "format" in header else "an earlier version"
    return f"{file} is of {written}; this version of taichi-silo goes on from format {FORMAT}"


def _whole(tree: dict, arrays: dict[str, np.ndarray]) -> dict:
    """The tree, its arrays put back in their places."""
    for path, values in arrays.items():
        *names, last = path.split("/")
        here = tree
        for name in names:
            here = here[name]
        here[last] = values
    return tree


def _without_arrays(tree: dict, path: str, arrays: dict) -> dict:
    """The tree less its arrays, which are gathered by their paths."""
    rest = {}
    for name, value in tree.items():
        if is_array(value):
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
        values = np.asarray(arrays[name])
        found.update(f"{name} {values.dtype.str} {values.shape}".encode())
        for first in range(0, max(len(values), 1), ROWS) if values.ndim else (0,):
            found.update((values[first : first + ROWS] if values.ndim else values).tobytes())
    return found.hexdigest()
