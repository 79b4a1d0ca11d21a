"""Figures of a run, and of many runs over each other, drawn from the files that a run leaves behind.

Nothing but the run's folder is read, so that figures can be redrawn at any time. A run that ended early is
drawn as far as it went; a figure without any data is left out.
"""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
from matplotlib import rc_context

from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import no_link
from taichi_silo.show.figures.batch import batch_figure
from taichi_silo.show.figures.collapse import run_collapse_figure
from taichi_silo.show.figures.forces import run_angle_figure, run_forces_figure
from taichi_silo.show.figures.outflow import run_outflow_figure
from taichi_silo.show.figures.response import response_figure
from taichi_silo.show.figures.style import STYLE
from taichi_silo.show.figures.void_ratio import run_void_ratio_figure
from taichi_silo.show.figures.wall_stress import run_wall_stress_figure
from taichi_silo.utils import atomic_write

__all__ = ["draw_all", "plot_batch", "plot_response", "plot_run"]

RUN_FIGURES = {
    "forces": run_forces_figure,
    "wall_friction_angle": run_angle_figure,
    "void_ratio": run_void_ratio_figure,
    "collapse": run_collapse_figure,
    "wall_stress": run_wall_stress_figure,
    "outflow": run_outflow_figure,
}


def plot_run(folder: Path) -> list[Path]:
    """Draw the figures of one run (Fig. 10 to 13 of the paper) into its folder `figures`; returns the paths written."""
    return draw_all(RUN_FIGURES, Result(folder, tolerant=True), Path(folder) / "figures")


def plot_batch(folders: dict[str, Path], target: Path) -> list[Path]:
    """Draw P, T and N of many runs, their folders given by name, into one figure; returns its path, if any has data."""
    runs = [Result(folder, name, tolerant=True) for name, folder in folders.items()]
    return draw_all({"forces": batch_figure}, runs, target)


def plot_response(table: pd.DataFrame, varied: list[str], response, target: Path) -> list[Path]:
    """Draw what a sweep found against what varied (see `response_figure`); returns the path, if there was anything."""
    return draw_all({"response": lambda rows: response_figure(rows, varied, response)}, table, target)


def draw_all(figures: dict[str, Callable], data, target: Path) -> list[Path]:
    """Draw figures, given by their names as functions of the data, into a folder; returns the paths of those with data.

    Raises BadInput if the folder or a file in it is a link.
    """
    no_link(target, *(target / f"{name}.png" for name in figures))
    target.mkdir(parents=True, exist_ok=True)
    written = []
    for name, make_figure in figures.items():
        with rc_context(STYLE):
            figure = make_figure(data)
            if figure is not None:
                written.append(target / f"{name}.png")
                with atomic_write.written(written[-1]) as passing:
                    figure.savefig(passing, format="png")
    return written
