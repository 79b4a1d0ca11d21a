"""Figures of element tests, from the tables that they leave."""

import numpy as np
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION, new_figure

COLORS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY)


def wall_angle_deg(curve) -> np.ndarray:
    """Angle whose tangent is sigma_12 / sigma_22: friction on the plates of a shear box."""
    return np.degrees(np.arctan2(curve.sigma_12_Pa, curve.sigma_22_Pa))


def element_figure(curve, title: str, sheared: bool) -> Figure:
    """Stresses, mobilised friction and void ratio of one test against its strain."""
    figure = new_figure(12.0, 4.2)
    stresses, friction, density = figure.subplots(1, 3)
    strain = 100.0 * curve.strain.abs()
    name = "shear strain (%)" if sheared else "axial logarithmic strain (%)"
    for column, color in zip(("11", "22", "33", "12"), COLORS, strict=False):
        if column != "12" or sheared:
            stresses.plot(strain, 1e-3 * curve[f"sigma_{column}_Pa"], color=color, label=rf"$\sigma_{{{column}}}$")
    stresses.set(xlabel=name, ylabel="stress, compression positive (kPa)")
    friction.plot(strain, curve.friction_angle_deg, color=BLUE, label="by principal stresses")
    if sheared:
        friction.plot(strain, wall_angle_deg(curve), color=VERMILLION, label=r"atan $\sigma_{12}/\sigma_{22}$")
    friction.set(xlabel=name, ylabel="mobilised friction angle (deg)", ylim=(0.0, None))
    density.plot(strain, curve.void_ratio, color=BLUE)
    density.set(xlabel=name, ylabel="void ratio")
    stresses.legend()
    if sheared:
        friction.legend()
    figure.suptitle(title)
    return figure


def paper_figure(curves: dict, column, label: str, title: str, references: tuple = ()) -> Figure:
    """Curves of several void ratios (colours), one panel a pressure, law alone (lines) and method (dots).

    Parameters
    ----------
    curves : (void ratio, pressure [Pa], "point" or "mpm") -> table.
    column : function of a table that returns what to draw; a list of (function, label) draws rows of panels.
    label : of the strain axis.
    title : of the figure.
    references : (row, value, words) of dashed lines.

    """
    pressures = sorted({key[1] for key in curves}, reverse=True)
    void_ratios = sorted({key[0] for key in curves})
    figure = new_figure(5.6 * len(pressures), 3.9 * len(column) + 0.5)
    panels = figure.subplots(len(column), len(pressures), sharex=True, sharey="row", squeeze=False)
    for k, (read, name) in enumerate(column):
        for panel, pressure in zip(panels[k], pressures, strict=True):
            for color, e in zip(COLORS, void_ratios, strict=False):
                exact, method = curves[e, pressure, "point"], curves[e, pressure, "mpm"]
                panel.plot(100 * exact.strain, read(exact), color=color, label=f"$e_0$ = {e:.2f}")
                some = method.iloc[:: max(1, len(method) // 25)]
                panel.plot(100 * some.strain, read(some), "o", color=color, markersize=4)
            for row, value, words in references:
                if row == k:
                    panel.axhline(value, color="#555555", linestyle="--", linewidth=1.2, label=words)
            panel.set_title(f"{pressure / 1e3:g} kPa")
        panels[k][0].set_ylabel(name)
    for panel in panels[-1]:
        panel.set_xlabel(label)
    panels[0][0].legend(loc="lower right", title="line: law alone, dots: MPM")
    figure.suptitle(title)
    return figure
