"""Figures of element tests, from the tables that they leave."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLUE, REFERENCE, VERMILLION, WORDS, new_figure

MARKERS = "os^Dv"  # of measured curves, one after the other


def wall_angle_deg(curve) -> np.ndarray:
    """Angle whose tangent is sigma_12 / sigma_22: friction on the plates of a shear box."""
    return np.degrees(np.arctan2(curve.sigma_12_Pa, curve.sigma_22_Pa))


def element_figure(
    curve: pd.DataFrame, title: str, sheared: bool, measured: Mapping[str, pd.DataFrame] | None = None
) -> Figure:
    """Stresses, mobilised friction and void ratio of one test against its strain, measured points over the curves.

    Parameters
    ----------
    curve : as an element test leaves it.
    title : of the figure.
    sheared : whether the strain is gamma.
    measured : curves by their names, with the same columns, nan where nothing was measured.

    """
    figure = new_figure(12.0, 4.7 if measured else 4.2)
    stresses, friction, density = figure.subplots(1, 3)
    strain = 100.0 * curve.strain.abs()
    name = "shear strain (%)" if sheared else "axial logarithmic strain (%)"
    for column, color in zip(("11", "22", "33", "12"), WORDS, strict=False):
        if column != "12" or sheared:
            stresses.plot(strain, 1e-3 * curve[f"sigma_{column}_Pa"], color=color, label=rf"$\sigma_{{{column}}}$")
    stresses.set(xlabel=name, ylabel="stress, compression positive (kPa)")
    friction.plot(strain, curve.friction_angle_deg, color=BLUE, label="by principal stresses")
    if sheared:
        friction.plot(strain, wall_angle_deg(curve), color=VERMILLION, label=r"atan $\sigma_{12}/\sigma_{22}$")
    friction.set(xlabel=name, ylabel="mobilised friction angle (deg)", ylim=(0.0, None))
    density.plot(strain, curve.void_ratio, color=BLUE)
    density.set(xlabel=name, ylabel="void ratio")
    for number, (label, points) in enumerate((measured or {}).items()):
        _draw_points((stresses, friction, density), points, sheared, MARKERS[number % len(MARKERS)], label)
    if measured:
        figure.legend(*density.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    stresses.legend()
    if sheared:
        friction.legend()
    figure.suptitle(title)
    return figure


def _draw_points(panels, points: pd.DataFrame, sheared: bool, marker: str, label: str) -> None:
    """Measured points over the curves of the same colours; the name stands once, for a legend of the figure."""
    stresses, friction, density = panels
    x = 100.0 * points.strain.abs()
    style: Any = {"linestyle": "none", "marker": marker, "markerfacecolor": "none", "markersize": 5}
    for column, color in zip(("11", "22", "33", "12"), WORDS, strict=False):
        if column != "12" or sheared:
            stresses.plot(x, 1e-3 * points[f"sigma_{column}_Pa"], color=color, **style)
    friction.plot(x, points.friction_angle_deg, color=BLUE, **style)
    if sheared:
        friction.plot(x, wall_angle_deg(points), color=VERMILLION, **style)
    density.plot(x, points.void_ratio, color=BLUE, **style)
    density.plot([], [], color=REFERENCE, label=f"measured: {label}", **style)
