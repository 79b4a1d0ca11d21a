"""The figure of the chart: error of the forces against cost, in each scene."""

import math

import pandas as pd
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, REFERENCE, SKY, VERMILLION, new_figure
from validation.accuracy.dials import NAMED
from validation.accuracy.table import WORST

COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, REFERENCE)
MARKERS = "osD^vP*X<>"
LEAST = 1e-4  # of errors, so that none falls off a logarithmic scale
ACROSS = 3  # panels
SIZE = 4.4  # inches of a panel


def error_figure(rows: pd.DataFrame, bars: dict[str, float]) -> Figure:
    """Errors of all dials against cost, the named settings joined by a line, and how far the truth itself is known.

    Parameters
    ----------
    rows : of `chart.csv`.
    bars : of the truth of each scene, in the measure of the figure.

    """
    names, listed = list(dict.fromkeys(rows["scene"])), list(dict.fromkeys(rows["dial"]))
    down = math.ceil(len(names) / ACROSS)
    figure = new_figure(SIZE * min(len(names), ACROSS), SIZE * down)
    across = min(len(names), ACROSS)
    panels = list(figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).flat)
    for panel, name in zip(panels, names, strict=False):
        some = rows[(rows["scene"] == name) & rows[WORST].notna()]
        for number, dial in enumerate(one for one in listed if one != NAMED):
            _dots(panel, some[some["dial"] == dial], number, dial)
        named = some[some["dial"] == NAMED].sort_values("core_seconds")
        panel.plot(
            named["core_seconds"], 100.0 * named[WORST].clip(LEAST), "o-", color=BLACK, lw=2.2, ms=7, label=NAMED
        )
        for row in named.itertuples():
            panel.annotate(row.setting, (row.core_seconds, 100.0 * max(getattr(row, WORST), LEAST)), xytext=(5, 6),
                           textcoords="offset points", fontsize=9)  # fmt: skip
        panel.axhspan(1e-9, 100.0 * max(bars.get(name, 0.0), LEAST), color=REFERENCE, alpha=0.15, lw=0)
        panel.set(xscale="log", yscale="log", ylim=(0.02, 300.0))
        panel.set_title(name, loc="left")
    for panel in panels[len(names) :]:
        panel.set_visible(False)
    for panel in panels[max(0, len(names) - across) : len(names)]:
        panel.set_xlabel("cost of the run (core-seconds)")
    figure.supylabel("largest error of P, T, N at the end, % of the weight")
    handles = dict(zip(*reversed(figure.axes[0].get_legend_handles_labels()), strict=True))
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=5, fontsize=9.5)
    return figure


def _dots(panel, rows: pd.DataFrame, number: int, dial: str) -> None:
    """The runs of one dial."""
    panel.plot(
        rows["core_seconds"], 100.0 * rows[WORST].clip(LEAST), MARKERS[number % len(MARKERS)],
        color=COLORS[number % len(COLORS)], fillstyle="full" if number < len(COLORS) else "none", ms=5, label=dial,
    )  # fmt: skip
