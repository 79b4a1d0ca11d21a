"""What was taken from a drawing: its closed lines with their numbers, the silo's inside and the bodies in it."""

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLUE, REFERENCE, STYLE, VERMILLION, new_figure
from taichi_silo.utils import atomic_write

TALL_IN, WIDE_IN = 7.0, 10.0  # that the lines may take
MOST_NUMBERS = 40


def draw_lines(
    file: Path, lines: Sequence[np.ndarray], number: int | None = None, bodies: Collection[int] = ()
) -> None:
    """Draw closed lines, each the corners (n, 2) [m], into a PNG file; the inside and the bodies by their numbers.

    Raises MachineFailed if it cannot be written.
    """
    with rc_context(STYLE), atomic_write.written(file) as passing:
        lines_figure(lines, number, bodies).savefig(passing, format="png")


def lines_figure(lines: Sequence[np.ndarray], number: int | None, bodies: Collection[int]) -> Figure:
    """Return the figure of `draw_lines`."""
    every = np.concatenate(lines)
    wide, high = np.maximum(np.ptp(every, axis=0), 1e-12)
    scale = min(WIDE_IN / wide, TALL_IN / high)
    figure = new_figure(max(4.0, wide * scale) + 1.2, max(2.0, high * scale) + 1.4)
    panel = figure.subplots()
    panel.set_aspect("equal")
    panel.set_xlabel("x of the drawing (m)")
    panel.set_ylabel("y of the drawing (m)")
    for place, corners in enumerate(lines, 1):
        ring = np.concatenate([corners, corners[:1]])
        if place == number:
            panel.fill(*corners.T, color="#F2E6C8", zorder=1.0)
        colour = BLUE if place == number or number is None else VERMILLION if place in bodies else REFERENCE
        taken = place == number or place in bodies
        panel.plot(*ring.T, color=colour, linewidth=2.0 if taken else 0.9, zorder=3.0 if taken else 2.0)
        if place in bodies:
            panel.fill(*corners.T, color="#CFCFCF", zorder=2.5)
        if len(lines) <= MOST_NUMBERS or taken:
            x, y = corners[int(np.lexsort((corners[:, 0], -corners[:, 1]))[0])]  # its upper left corner
            panel.annotate(f"{place}", (x, y), (4, -4), textcoords="offset points", va="top", color=colour, zorder=4.0)
    return figure
