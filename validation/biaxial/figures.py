"""Figures of plane strain compression: load curves, and specimens as they stand."""

import math

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import REFERENCE, new_figure
from taichi_silo.show.figures.style import WORDS as COLORS

FIELD = {"void_ratio": ("void ratio", "viridis"), "path": ("shear strain (path length)", "magma")}


def load_figure(curves: dict, title: str, references: tuple = ()) -> Figure:
    """Mobilised friction angle and void ratio against shortening, one curve a case.

    `references` are (value in degrees, words) of dashed lines.
    """
    figure = new_figure(11.0, 4.6)
    friction, density = figure.subplots(1, 2, width_ratios=(2, 1))
    for number, (name, curve) in enumerate(curves.items()):
        color, style = COLORS[number % len(COLORS)], ("-", "--")[number // len(COLORS) % 2]
        friction.plot(100 * curve.shortening, curve.friction_angle_deg, style, color=color, label=name)
        density.plot(100 * curve.shortening, curve.void_ratio, style, color=color)
    for value, words in references:
        friction.axhline(value, color=REFERENCE, linestyle=":", linewidth=1.4, label=words)
    friction.set(xlabel="shortening u / h (%)", ylabel="mobilised friction angle (deg)", ylim=(0.0, None))
    density.set(xlabel="shortening u / h (%)", ylabel="mean void ratio")
    friction.legend(fontsize=10)
    figure.suptitle(title)
    return figure


def specimens_figure(specimens: dict, field: str, title: str) -> Figure:
    """Deformed specimens side by side, each point as large as its share of the lattice, with the measured band.

    Parameters
    ----------
    specimens : name -> (points, spacing [m], band or None).
    field : "void_ratio" or "path".
    title : of the figure.

    """
    words, colors = FIELD[field]
    values = np.concatenate([points[field] for points, _, _ in specimens.values()])
    scale = Normalize(*np.quantile(values, (0.005, 0.995)))
    figure = new_figure(1.4 + 1.7 * len(specimens), 4.9)
    panels = figure.subplots(1, len(specimens), sharey=True, squeeze=False)[0]
    for panel, (name, (points, spacing, band)) in zip(panels, specimens.items(), strict=True):
        place = 1e3 * points["position"]
        size = np.full(len(place), 1e3 * spacing * math.sqrt(4.0 / math.pi) * 1.1)
        panel.add_collection(
            EllipseCollection(
                size,
                size,
                np.zeros(len(place)),
                units="xy",
                offsets=place,
                array=points[field],
                cmap=colors,
                norm=scale,
                transOffset=panel.transData,
                linewidths=0,
            )  # fmt: skip
        )
        if band is not None and band.found:
            low, high = 1e3 * band.middles[0], 1e3 * band.middles[-1]
            panel.plot((low[0], high[0]), (low[1], high[1]), color="white", linewidth=1.0, linestyle="--")
        panel.set(xlim=(-8, 52), ylim=(-2, 142), aspect="equal", xlabel="x (mm)")
        panel.set_title(name, fontsize=10)
        panel.grid(visible=False)
    panels[0].set_ylabel("y (mm)")
    figure.colorbar(ScalarMappable(scale, colors), ax=panels, label=words, shrink=0.75)
    figure.suptitle(title)
    return figure
