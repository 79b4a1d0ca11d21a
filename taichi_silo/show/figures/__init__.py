"""Figures of a run, and of several runs side by side, drawn from the files that a run leaves behind.

Nothing but the run's folder is read, so that figures can be redrawn at any time. A run that ended early is
drawn as far as it went; a figure without any data is left out.
"""

from pathlib import Path

import pandas as pd
from matplotlib import rc_context

from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import no_link
from taichi_silo.show.figures.batch import batch_figure
from taichi_silo.show.figures.forces import case_angles_figure, case_forces_figure, run_angle_figure, run_forces_figure
from taichi_silo.show.figures.response import response_figure
from taichi_silo.show.figures.style import STYLE
from taichi_silo.show.figures.void_ratio import case_void_ratio_figure, run_void_ratio_figure
from taichi_silo.show.figures.wall_stress import case_wall_stress_figure, run_wall_stress_figure
from taichi_silo.utils import atomic_write

__all__ = ["plot_batch", "plot_cases", "plot_response", "plot_run"]

RUN_FIGURES = {
    "forces": run_forces_figure,
    "wall_friction_angle": run_angle_figure,
    "void_ratio": run_void_ratio_figure,
    "wall_stress": run_wall_stress_figure,
}
CASE_FIGURES = {
    "forces": case_forces_figure,
    "wall_friction_angle": case_angles_figure,
    "void_ratio": case_void_ratio_figure,
    "wall_stress": case_wall_stress_figure,
}


def plot_run(folder: Path) -> list[Path]:
    """Draw the figures of one run (Fig. 10 to 13 of the paper) and return the paths written.

    Parameters
    ----------
    folder : Path
        The run's folder; the figures go to `folder/figures`.
    """
    return _draw(RUN_FIGURES, Result(folder, tolerant=True), Path(folder) / "figures")


def plot_cases(folders: dict[str, Path], target: Path) -> list[Path]:
    """Draw several runs side by side, one panel for each initial void ratio, and return the paths written.

    Parameters
    ----------
    folders : dict
        The runs' folders by the name that the legends show, such as "dense, smooth walls".
    target : Path
        Folder of the figures.
    """
    return _draw(CASE_FIGURES, _runs(folders), Path(target))


def plot_batch(folders: dict[str, Path], target: Path) -> list[Path]:
    """Draw P, T and N of many runs into one figure and return the path written, if there was anything to draw.

    Parameters
    ----------
    folders : dict
        The runs' folders by their names.
    target : Path
        Folder of the figure.
    """
    return _draw({"forces": batch_figure}, _runs(folders), Path(target))


def plot_response(table: pd.DataFrame, varied: list[str], response, target: Path) -> list[Path]:
    """Draw what a sweep found against what varied, and return the path written, if there was anything to draw.

    Parameters
    ----------
    table : DataFrame
        Of all runs.
    varied : list
        Its columns of what varied.
    response :
        With the column `y`, and `x` and `colour`, if they are wanted.
    target : Path
        Folder of the figure.
    """
    return _draw({"response": lambda rows: response_figure(rows, varied, response)}, table, target)


def _runs(folders: dict[str, Path]) -> list[Result]:
    return [Result(folder, label, tolerant=True) for label, folder in folders.items()]


def _draw(figures, data, target: Path) -> list[Path]:
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
