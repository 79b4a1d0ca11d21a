"""The runs that are compared, each with a name of its own."""

from dataclasses import replace
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.report.page import read_run


def read_runs(folders: list[Path]) -> list[RunFiles]:
    """Runs labelled by the shortest ends of their paths that differ.

    Raises
    ------
    BadInput
        if a folder holds no run of a silo, holds no forces yet, or is given twice.

    """
    runs = [read_run(folder) for folder in folders]
    places = [run.folder.resolve() for run in runs]
    for run, place in zip(runs, places, strict=True):
        if places.count(place) > 1:
            raise BadInput(f"folder {run.folder} is given twice; it must be another run")
        if run.forces.empty:
            raise BadInput(f"folder is {run.folder}; it must be a run that has begun, and its forces.csv has no rows")
    return [replace(run, label=label) for run, label in zip(runs, _labels(places), strict=True)]


def _labels(places: list[Path]) -> list[str]:
    for depth in range(1, max(len(place.parts) for place in places)):
        labels = ["/".join(place.parts[-depth:]) for place in places]
        if len(set(labels)) == len(labels):
            return labels
    return [place.as_posix() for place in places]
