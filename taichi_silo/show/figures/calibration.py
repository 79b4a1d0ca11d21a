"""Figures of a calibration: measured points over the curves of the law."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import COLORS, make_logarithmic, new_figure, put_title


class Compression(NamedTuple):
    """An oedometer test: measured points, which of them are of first loading, and the law's curve."""

    name: str
    stress_Pa: np.ndarray
    void_ratio: np.ndarray
    loading: np.ndarray
    line_stress_Pa: np.ndarray
    line_void_ratio: np.ndarray


class Shearing(NamedTuple):
    """A triaxial test: measured points (nan where none), and the law's curves; logarithmic strains."""

    name: str
    strain: np.ndarray
    deviator_Pa: np.ndarray
    volume_strain: np.ndarray
    line_strain: np.ndarray
    line_deviator_Pa: np.ndarray
    line_volume_strain: np.ndarray


POINTS: Any = {"linestyle": "none", "marker": "o", "markersize": 5, "markeredgewidth": 1.2}
MOST_POINTS = 80  # of a test that are drawn


def compression_figure(tests: list[Compression]) -> Figure | None:
    """Void ratio against the logarithm of the axial stress; None without tests."""
    if not tests:
        return None
    figure = new_figure(7.6, 5.6)
    panel = figure.subplots()
    for number, test in enumerate(tests):
        color = COLORS[number % len(COLORS)]
        for chosen, fill in ((test.loading, color), (~test.loading, "none")):
            every = max(1, int(chosen.sum()) // MOST_POINTS)
            x, y = 1e-3 * test.stress_Pa[chosen][::every], test.void_ratio[chosen][::every]
            panel.plot(x, y, color=color, markerfacecolor=fill, **POINTS)
        panel.plot(1e-3 * test.line_stress_Pa, test.line_void_ratio, color=color, label=test.name)
    make_logarithmic(panel.xaxis)
    panel.set(xlabel="axial stress (kPa)", ylabel="void ratio")
    panel.legend()
    put_title(figure, "Oedometer tests", "points: measured (open: not of first loading, not fitted); lines: the law")
    return figure


def shearing_figure(tests: list[Shearing]) -> Figure | None:
    """Deviator and volume strain against the axial strain; None without tests."""
    if not tests:
        return None
    figure = new_figure(12.0, 5.6)
    deviators, volumes = figure.subplots(1, 2)
    for number, test in enumerate(tests):
        color = COLORS[number % len(COLORS)]
        every = max(1, len(test.strain) // MOST_POINTS)
        x = 100.0 * test.strain[::every]
        deviators.plot(x, 1e-3 * test.deviator_Pa[::every], color=color, markerfacecolor="none", **POINTS)
        deviators.plot(100.0 * test.line_strain, 1e-3 * test.line_deviator_Pa, color=color, label=test.name)
        volumes.plot(x, 100.0 * test.volume_strain[::every], color=color, markerfacecolor="none", **POINTS)
        volumes.plot(100.0 * test.line_strain, 100.0 * test.line_volume_strain, color=color)
    deviators.set(xlabel="axial logarithmic strain (%)", ylabel="q (kPa)")
    volumes.set(xlabel="axial logarithmic strain (%)", ylabel="loss of volume (%)")
    figure.legend(loc="outside lower center", ncols=2)
    put_title(figure, "Drained triaxial compression", "points: measured; lines: the law")
    return figure
