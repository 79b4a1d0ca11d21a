"""A whole comparison: read, computed, and left in a folder."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import no_link, writable
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
    """A comparison: its runs, tables (None if they were not asked for) and files."""

    runs: list[Result]
    differences: pd.DataFrame
    janssen: pd.DataFrame | None
    deviations: pd.DataFrame | None
    files: list[Path]
    remarks: list[str]  # on what was measured

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


def compared(folders: list[Path], output: Path, *, janssen: bool, csv: list[Path]) -> Comparison:
    """Compare runs, with theory if `janssen`, with measurements in `csv` files, and leave tables and figures.

    Raises BadInput before anything is written: if a folder or a file is not what it must be, or there is nothing to
    compare with.
    """
    output, runs = place(output, "output"), read_runs(folders)
    measured = [read(file) for file in csv]
    remarks = [remark for one in measured for remark in one.remarks]
    if len({one.place for one in measured if one.kind == "curves"}) > 1:
        raise BadInput("csv: curves are given over displacement and over time; they must all be over one of them")
    surfaces = {run.scene.silo.height_m for run in runs}
    if len(surfaces) > 1 and (deep := [one.name for one in measured if one.place == "depth_m"]):
        raise BadInput(f"csv: {deep[0]} has depths, and the silos are not of one height; it must have height_m")
    measured = [one.above_bottom(max(surfaces)) for one in measured]
    if len(runs) == 1 and not (janssen or measured):
        raise BadInput("runs: there is 1; it must be 2 or more, or one with --janssen or --csv FILE")
    with as_left(runs[0].folder if len(runs) == 1 else f"one of {len(runs)}"):
        found = tables.differences(runs)
        theory = tables.janssen(runs) if janssen else None
        away = tables.deviations(runs, measured) if measured else None
    no_link(*(output / f"{name}{end}" for name in PRODUCTS for end in ("", ".part")))
    output, files = writable(output), []
    for name in PRODUCTS:
        (output / name).unlink(missing_ok=True)
    for name, table in (("compare.csv", found), ("janssen.csv", theory), ("deviation.csv", away)):
        if table is not None:
            files.append(output / name)
            with atomic_write.written(files[-1]) as passing:
                table.to_csv(passing, index=False, encoding="utf-8")
    files += plot_compared(runs, measured, janssen, output)
    return Comparison(runs, found, theory, away, files, remarks)


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
