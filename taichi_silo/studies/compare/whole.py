"""A whole comparison: read, computed, and left in a folder."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput, Way, way
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import no_link, writable
from taichi_silo.show import beside_walls
from taichi_silo.show.figures.compare import plot_compared
from taichi_silo.studies.compare import tables
from taichi_silo.studies.compare.measured import read
from taichi_silo.utils import atomic_write
from taichi_silo.utils.bounded_reading import as_left, place

PRODUCTS = (  # paper.csv: of version 0.2
    "compare.csv", "janssen.csv", "deviation.csv", "paper.csv", "compare_forces.png", "compare_walls.png",
)  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """A comparison.

    Attributes
    ----------
    runs : with their labels in the tables.
    differences : a row for each quantity, state and run: value, unit, difference in per cent of the first run.
    janssen : a row for each force and run after filling, beside theory; None if not asked for.
    deviations : a row for each measured curve and run: rms and largest deviation; None without measurements.
    files : what was written; empty without an output folder.

    """

    runs: list[Result]
    differences: pd.DataFrame
    janssen: pd.DataFrame | None
    deviations: pd.DataFrame | None
    files: list[Path]
    remarks: list[str]  # on what was measured, and what theory does not know

    def as_json(self) -> dict:
        """All numbers, in SI units."""
        tables = {name: getattr(self, name) for name in ("differences", "janssen", "deviations")}
        return {
            "runs": {run.label: str(run.folder) for run in self.runs},
            **{
                name: table.astype(object).where(table.notna(), None).to_dict("records")
                for name, table in tables.items()
                if table is not None
            },
            "remarks": self.remarks,
            "files": [str(file) for file in self.files],
        }


def compare(
    runs: str | os.PathLike | Sequence[str | os.PathLike],
    output: str | os.PathLike | None = None,
    *,
    janssen: bool = False,
    csv: str | os.PathLike | Sequence[str | os.PathLike] = (),
) -> Comparison:
    """Lay runs over each other, and over theory and measurements: tables of the differences, and figures.

    Parameters
    ----------
    runs : runs or their folders; the others are set against the first. One is enough beside theory or measurements.
    output : folder for tables and figures; an earlier comparison there is replaced. Nothing is written without it.
    janssen : set the forces after filling beside Janssen's theory.
    csv : files of measurements, with columns as `taichi-silo compare --help` names them.

    Returns
    -------
    Tables: `differences`, and `janssen` and `deviations` if they were asked for.

    Raises
    ------
    BadInput
        before anything is written, if a folder or a file is not what it must be, or there is nothing to compare with.

    """
    target = None if output is None else place(output, "output")
    results = read_runs(_several(runs))
    measured = [read(file) for file in _several(csv)]
    if len({one.place for one in measured if one.kind == "curves"}) > 1:
        raise BadInput("csv: curves are given over displacement and over time; they must all be over one of them")
    surfaces = {run.scene.silo.height_m for run in results}
    if len(surfaces) > 1 and (deep := [one.name for one in measured if one.place == "depth_m"]):
        raise BadInput(f"csv: {deep[0]} has depths, and the silos are not of one height; it must have height_m")
    measured = [one.above_bottom(max(surfaces)) for one in measured]
    if len(results) == 1 and not (janssen or measured):
        one, files = way("janssen"), Way("csv=[...]", "--csv FILE")
        raise BadInput(f"runs: there is 1; it must be 2 or more, or one with {one} or {files}", one, files)
    with as_left(results[0].folder if len(results) == 1 else f"one of {len(results)}"):
        found = tables.differences(results)
        theory = tables.janssen(results) if janssen else None
        away = tables.deviations(results, measured) if measured else None
    remarks = [
        remark
        for one in measured
        for remark in (*one.remarks, *(words for run in results for words in tables.unused(run, one)))
    ]
    if janssen:
        remarks += [f"{run.label}: {words}" for run in results if (words := beside_walls.beyond_janssen(run))]
    comparison = Comparison(results, found, theory, away, [], remarks)
    return comparison if target is None else _left(comparison, target, measured)


def _several(given: str | os.PathLike | Sequence[str | os.PathLike]) -> list[Path]:
    """One path, or several, as a list; a `Result` stands for that of its folder."""
    return [Path(one) for one in ([given] if isinstance(given, str | os.PathLike) else given)]


def _left(found: Comparison, output: Path, measured: list) -> Comparison:
    """The comparison with its files."""
    no_link(*(output / f"{name}{end}" for name in PRODUCTS for end in ("", ".part")))
    output, files = writable(output), []
    for name in PRODUCTS:
        (output / name).unlink(missing_ok=True)
    tables = (("compare.csv", found.differences), ("janssen.csv", found.janssen), ("deviation.csv", found.deviations))
    for name, table in tables:
        if table is not None:
            files.append(output / name)
            with atomic_write.written(files[-1]) as passing:
                table.to_csv(passing, index=False, encoding="utf-8")
    files += plot_compared(found.runs, measured, found.janssen is not None, output)
    return replace(found, files=files)


def read_runs(folders: list[Path]) -> list[Result]:
    """Runs labelled by the shortest ends of their paths that differ.

    Raises BadInput if a folder holds no run of a silo, holds no forces yet, or is given twice.
    """
    places = [Result(folder).folder.resolve() for folder in folders]
    for folder, place_ in zip(folders, places, strict=True):
        if places.count(place_) > 1:
            raise BadInput(f"folder {folder} is given twice; it must be another run")
    runs = [Result(folder, label, tolerant=True) for folder, label in zip(folders, _labels(places), strict=True)]
    for run in runs:
        run.scene  # noqa: B018 - without which nothing can be compared
        if run.forces.empty:
            raise BadInput(f"folder is {run.folder}; it must be a run that has begun, and its forces.csv has no rows")
    return runs


def _labels(folders: list[Path]) -> list[str]:
    for depth in range(1, max(len(folder.parts) for folder in folders)):
        labels = ["/".join(folder.parts[-depth:]) for folder in folders]
        if len(set(labels)) == len(labels):
            return labels
    return [folder.as_posix() for folder in folders]
