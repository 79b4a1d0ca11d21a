"""Figures of the chart: error against cost, and residual forces against the speed of the bottom."""

import math

import pandas as pd
from matplotlib.figure import Figure

from taichi_silo.plots.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, REFERENCE, SKY, VERMILLION, new_figure

COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
MARKERS = "osD^vP*X<>"
SMALL = {
    "error_P": "P, bottom force",
    "error_T": "T, wall friction",
    "error_profile": "wall stress over height",
    "error_zone": "zone thickness",
}
FLOOR = "#DDDDDD"
LEAST = 1e-4  # of errors, so that none falls off a logarithmic scale


def error_figure(rows: pd.DataFrame, floor: pd.Series) -> Figure:
    """Error of N against cost for every dial, with the front; small panels for what else is measured.

    Parameters
    ----------
    rows : of `chart.csv`, one pair of walls.
    floor : errors between runs that differ by rounding only.

    """
    some = rows[(rows.purpose == "accuracy") & (rows.dial != "reference") & (rows.dial != "rounding")]
    figure = new_figure(13.0, 7.2)
    grid = figure.add_gridspec(2, 4, width_ratios=(1.0, 1.0, 0.62, 0.62))
    large = figure.add_subplot(grid[:, :2])
    panels = [figure.add_subplot(grid[k // 2, 2 + k % 2]) for k in range(4)]
    for panel, measure in ((large, "error_N"), *zip(panels, SMALL, strict=True)):
        panel.tick_params(labelsize=12 if panel is large else 9)
        if not some[measure].gt(0.0).any():
            panel.text(0.5, 0.5, "nothing to compare", ha="center", color=REFERENCE, transform=panel.transAxes)
            panel.set(xticks=(), yticks=())
            continue
        size = 8 if panel is large else 4.5
        _floor(panel, floor.get(measure, math.nan))
        for k, (_, dial) in enumerate(some.groupby("dial", sort=False)):
            _dial(panel, dial, measure, k, size)
        panel.set(xscale="log", yscale="log")
    best = some[some.on_front].drop_duplicates("key").sort_values("cost_core_seconds")
    large.plot(
        best.cost_core_seconds, best.error_N.clip(LEAST), "-", color=BLACK, linewidth=6, alpha=0.18, label="front",
        drawstyle="steps-post", zorder=1,
    )  # fmt: skip
    for panel, title in zip(panels, SMALL.values(), strict=True):
        panel.set_title(title, fontsize=10.5, loc="left")
    walls, reference = rows.walls.iloc[0], rows.reference.iloc[0]
    large.set(xlabel="cost (core-seconds)", ylabel="error of N over u (-)")
    large.set_title(f"Dense sand, {walls} walls; reference: {reference}", loc="left")
    figure.supxlabel(
        "one dial at a time about the base; shaded: the difference of runs that differ by rounding only", fontsize=10
    )
    figure.legend(*large.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=10)
    return figure


def _dial(panel, rows: pd.DataFrame, measure: str, number: int, size: float) -> None:
    rows = rows[rows[measure].notna()].sort_values("cost_core_seconds")
    line = "-" if rows.setting.str.fullmatch(r"[\d.e+-]+( \S+)?").all() else ""  # numbers follow each other
    panel.plot(
        rows.cost_core_seconds, rows[measure].clip(LEAST), line + MARKERS[number % len(MARKERS)],
        color=COLORS[number % len(COLORS)], fillstyle="full" if number < len(COLORS) else "none", markersize=size,
        linewidth=1.0, label=rows.dial.iloc[0] if len(rows) else None,
    )  # fmt: skip


def _floor(panel, height: float) -> None:
    if math.isfinite(height) and height > 0.0:
        panel.axhspan(LEAST / 10.0, height, color=FLOOR, linewidth=0, zorder=0)


def speed_figure(rows: pd.DataFrame, floor: float) -> Figure:
    """Residual N against the speed of the bottom, as it is and with possible causes removed; and the inertial number.

    Parameters
    ----------
    rows : of `chart.csv` with the purpose "speed", one pair of walls.
    floor : scatter of N between runs that differ by rounding only, relative; shaded about the slowest run.

    """
    figure = new_figure(11.0, 5.2)
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    for k, (name, series) in enumerate(rows.groupby("dial", sort=False)):
        series = series.sort_values("flow.speed_m_per_s")
        speed = 1e3 * series["flow.speed_m_per_s"]
        look = {"color": COLORS[k % len(COLORS)], "marker": MARKERS[k], "markersize": 7, "linewidth": 1.6}
        force = 1e-3 * series["residual_N_N_per_m"]
        left.plot(speed, force, label=name.removeprefix("speed, "), **look)
        right.plot(speed, series.inertial_number_99th_percentile, **look)
        if k == 0 and math.isfinite(floor) and len(force) and math.isfinite(force.iloc[0]):
            left.axhspan((1.0 - floor) * force.iloc[0], (1.0 + floor) * force.iloc[0], color=FLOOR, linewidth=0)
    left.set(xscale="log", xlabel="speed of the bottom (mm/s)", ylabel="residual wall normal force N (kN/m)")
    right.set(xscale="log", yscale="log", xlabel="speed of the bottom (mm/s)", ylabel="inertial number (-)")
    right.axhline(1e-3, color=REFERENCE, linestyle="--", linewidth=1.2)
    right.text(0.03, 1.1e-3, "quasi-static below", color=REFERENCE, fontsize=9.5, transform=right.get_yaxis_transform())
    left.set_title("Has N a limit as the bottom slows?", loc="left")
    figure.legend(loc="outside lower center", ncols=3, fontsize=10.5)
    return figure
