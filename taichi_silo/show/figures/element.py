"""Figures of element tests, from the tables that they leave."""

import numpy as np
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLUE, VERMILLION, WORDS, new_figure


def wall_angle_deg(curve) -> np.ndarray:
    """Angle whose tangent is sigma_12 / sigma_22: friction on the plates of a shear box."""
    return np.degrees(np.arctan2(curve.sigma_12_Pa, curve.sigma_22_Pa))


def element_figure(curve, title: str, sheared: bool) -> Figure:
    """Stresses, mobilised friction and void ratio of one test against its strain."""
    figure = new_figure(12.0, 4.2)
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
    stresses.legend()
    if sheared:
        friction.legend()
    figure.suptitle(title)
    return figure
