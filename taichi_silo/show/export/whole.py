"""A whole export: asked for, checked, and written in one piece or not at all."""

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from taichi_silo.errors import BadInput, way
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import no_link, writable
from taichi_silo.show.export import tables, vtkhdf, wall_loads
from taichi_silo.utils.bounded_reading import as_left, place
from taichi_silo.utils.machine_faults import of_file


class Format(NamedTuple):
    """How a format is written, how its file or folder is called where no name is given, and which of both it is.

    Attributes
    ----------
    write : into a path, telling of each state that is done; returns their number.
    name : of the file or folder.
    beside : the other file that belongs to a file; None of a folder.

    """

    write: Callable[[Result, Path, Callable[[], None]], int]
    name: str
    beside: Callable[[Path], Path] | None = None

    def files(self, target: Path) -> list[Path]:
        """What is there of it."""
        if self.beside is None:
            return [*target.glob("*.*")]
        return [one for one in (target, self.beside(target)) if one.exists()]


FORMATS = {
    "vtkhdf": Format(vtkhdf.write, "silo.vtkhdf", vtkhdf.walls_beside),
    "csv": Format(tables.write, "csv"),
    "wall-loads": Format(wall_loads.write, "wall-loads"),
}


class Exported(NamedTuple):
    """What was written.

    Attributes
    ----------
    file : the file, or the folder of tables.
    states : how many it holds.
    bytes : of all files.

    """

    file: Path
    states: int
    bytes: int


def export(
    run: str | os.PathLike,
    file: str | os.PathLike | None = None,
    *,
    kind: str = "vtkhdf",
    overwrite: bool = False,
    tracked: Callable[[Iterable[int]], Iterable[int]] = iter,
) -> Exported:
    """Write all states of a run with the fields that follow from them, or its wall pressures, for other programs.

    Parameters
    ----------
    run : a `Result`, or its folder.
    file : the file, or the folder of tables; silo.vtkhdf, csv or wall-loads in the run's folder if absent.
    kind : "vtkhdf" (points and walls with time, for ParaView 5.12 and later), "csv" (a table a state) or "wall-loads"
        (pressures on the walls, as tables and for Abaqus).
    overwrite : replace an export that is there.
    tracked : what the numbers of the states are passed through as they are written, such as a progress bar (`tqdm`).

    Returns
    -------
    What was written; its `file` is the path.

    Raises
    ------
    BadInput
        before any work, if that is not possible.

    """
    if kind not in FORMATS:
        raise BadInput(f"format is {kind}; it must be one of {', '.join(FORMATS)}")
    found, wanted = Result(run), FORMATS[kind]
    if kind != "wall-loads":
        found.need_states()
    elif not len(found.walls):
        raise BadInput(
            f"folder is {found.folder}; it must be that of a run with wall stresses, and its walls.csv has none"
        )
    target = found.folder / wanted.name if file is None else place(file, "output")
    is_file, anew = wanted.beside is not None, way("overwrite")
    if (any(target.glob("*")) if target.is_dir() else target.exists() or wanted.files(target)) and not overwrite:
        raise BadInput(f"output {target} is there already; give another name, or {anew} to replace it", anew)
    if target.exists() and target.is_dir() == is_file:
        raise BadInput(f"output is {target}; it must be a {'file' if is_file else 'folder'} for {kind}")
    written = [target] if wanted.beside is None else [target, wanted.beside(target)]
    no_link(*(one.with_name(f"{one.name}{end}") for one in written for end in ("", ".part")), *wanted.files(target))
    writable(target.parent)
    steps = iter(tracked(range(len(found.snapshots))))

    def seen() -> None:
        next(steps, None)

    try:
        with as_left(found.folder):
            next(steps, None)
            count = wanted.write(found, target, seen)
        for _ in steps:
            continue  # a format with fewer parts than states
    except OSError as error:
        raise of_file(error, target) from error
    return Exported(target, count, sum(one.stat().st_size for one in wanted.files(target)))
