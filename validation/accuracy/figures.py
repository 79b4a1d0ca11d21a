"""Figures of the chart: error against cost, and residual forces against the speed of the bottom."""

import math

import pandas as pd
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, REFERENCE, SKY, VERMILLION, new_figure

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
    """Error of N against cost for everything varied, with the Pareto front; small panels for what else is measured.

    Parameters
    ----------
    rows : of `chart.csv`, one pair of walls.
    floor : errors between runs that differ by rounding only.

    """
    itself = rows.key.isin(rows.key[rows.dial == "reference"])
    some = rows[(rows.purpose == "accuracy") & (rows.dial != "rounding") & ~itself]
    figure = new_figure(13.0, 7.2)
    grid = figure.add_gridspec(2, 4, width_ratios=(1.0, 1.0, 0.62, 0.62))
    large = figure.add_subplot(grid[:, :2])
    panels = [figure.add_subplot(grid[k // 2, 2 + k % 2]) for k in range(4)]
    for panel, measure in ((large, "error_N"), *zip(panels, SMALL, strict=True)):
        panel.tick_params(which="both", labelsize=12 if panel is large else 8.5)
        if not some[measure].gt(0.0).any():
            panel.text(0.5, 0.5, "nothing to compare", ha="center", color=REFERENCE, transform=panel.transAxes)
            panel.set(xticks=(), yticks=())
            continue
        size = 8 if panel is large else 4.5
        _floor(panel, floor.get(measure, math.nan))
        for k, (_, varied) in enumerate(some.groupby("dial", sort=False)):
            _curve(panel, varied, measure, k, size)
        panel.set(xscale="log", yscale="log", ylim=_limits(some[measure]))
    best = some[some.on_front].drop_duplicates("key").sort_values("cost_core_seconds")
    large.plot(
        best.cost_core_seconds, best.error_N.clip(LEAST), "-", color=BLACK, linewidth=6, alpha=0.18,
        label="Pareto front", drawstyle="steps-post", zorder=1,
    )  # fmt: skip
    for panel, title in zip(panels, SMALL.values(), strict=True):
        panel.set_title(title, fontsize=10.5, loc="left")
    walls, reference = rows.walls.iloc[0], rows.reference.iloc[0]
    large.set(xlabel="cost (core-seconds)", ylabel="error of N over u (-)")
    for panel in panels[2:]:
        panel.set_xlabel("core-seconds", fontsize=9.5)
    large.set_title(f"Dense sand between {walls} walls, one setting at a time (circled: the base)", loc="left")
    figure.suptitle(
        f"Errors against {reference}; shaded: less than what rounding alone makes of a run", fontsize=11, x=0.01,
        ha="left", color=REFERENCE,
    )  # fmt: skip
    base = rows[(rows.dial == "rounding") & (rows.setting == "none")]
    large.plot(
        base.cost_core_seconds, base.error_N.clip(LEAST), "o", color=BLACK, fillstyle="none", markersize=18,
        markeredgewidth=1.5,
    )  # fmt: skip
    figure.legend(*large.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=10)
    return figure


def _curve(panel, rows: pd.DataFrame, measure: str, number: int, size: float) -> None:
    """Errors of one varied setting, joined by a line where its values are numbers."""
    rows = rows[rows[measure].notna()].sort_values("cost_core_seconds")
    line = "-" if rows.setting.str.fullmatch(r"[\d.e+-]+( \S+)?").all() else ""  # numbers follow each other
    panel.plot(
        rows.cost_core_seconds, rows[measure].clip(LEAST), line + MARKERS[number % len(MARKERS)],
        color=COLORS[number % len(COLORS)], fillstyle="full" if number < len(COLORS) else "none", markersize=size,
        linewidth=1.0, label=rows.dial.iloc[0] if len(rows) else None,
    )  # fmt: skip


def _limits(errors: pd.Series) -> tuple[float, float]:
    """Ends of a logarithmic axis: all errors but 0, with some room."""
    errors = errors[errors > 0.0].clip(LEAST)
    return 0.6 * errors.min(), 1.6 * errors.max()


def _floor(panel, height: float) -> None:
    """Shade the errors that rounding alone makes."""
    if math.isfinite(height) and height > 0.0:
        panel.axhspan(LEAST / 10.0, height, color=FLOOR, linewidth=0, zorder=0)


def speed_figure(rows: pd.DataFrame, floor: float) -> Figure:
    """Residual N as the bottom slows, as it is and with possible causes changed; and against the inertial number.

    A law without time makes sand of a hundredfold inertia do what lighter sand does ten times as fast: one curve at the
    right. A series that parts from it changes what else counts.

    Parameters
    ----------
    rows : of `chart.csv` with the purpose "speed", one pair of walls.
    floor : scatter of N between runs that differ by rounding only, relative; shaded about the slowest run as it is.

    """
    figure = new_figure(12.0, 5.4)
    left, right = figure.subplots(1, 2, sharey=True)
    for k, (name, series) in enumerate(rows.groupby("dial", sort=False)):
        series = series.sort_values("flow.speed_m_per_s")
        look = {"color": COLORS[k % len(COLORS)], "marker": MARKERS[k], "markersize": 7, "linewidth": 1.6}
        force = 1e-3 * series["residual_N_N_per_m"]
        left.plot(1e3 * series["flow.speed_m_per_s"], force, label=name.removeprefix("speed: "), **look)
        scaled = series.get("method.mass_scaling", 1.0)  # the certificate's number is that of true masses
        right.plot(series.inertial_number_99th_percentile * scaled**0.5, force, **look)
        slowest = force.dropna().iloc[:1]
        if k == 0 and math.isfinite(floor) and len(slowest):
            left.axhspan((1.0 - floor) * slowest.iloc[0], (1.0 + floor) * slowest.iloc[0], color=FLOOR, linewidth=0)
    speeds = sorted(1e3 * rows["flow.speed_m_per_s"].unique())
    left.set(xscale="log", xlabel="speed of the bottom (mm/s)", ylabel="residual wall normal force N (kN/m)")
    left.set_xticks(speeds, [f"{speed:g}" for speed in speeds])
    left.minorticks_off()
    right.set(xscale="log", xlabel="inertial number, 99th percentile (-)")
    left.set_title("Has N a limit as the bottom slows?", loc="left")
    right.set_title("At equal inertial number, equal forces?", loc="left")
    figure.legend(loc="outside lower center", ncols=3, fontsize=10.5)
    return figure
