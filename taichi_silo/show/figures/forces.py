"""Forces on bottom and walls, and the wall friction angle, against the bottom displacement (Fig. 10, 11)."""

import textwrap

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from taichi_silo.runs.result import Result
from taichi_silo.show import theory
from taichi_silo.show.figures.style import (
    BLUE,
    GREEN,
    REFERENCE,
    VERMILLION,
    line_colors,
    new_figure,
    put_title,
    start_at_zero,
)
from taichi_silo.show.titles import sand_title, title

SMOOTHING = 0.005  # window of the median lines, as a fraction of the whole displacement
LEAST_SHARE = 0.01  # of the weight: a smaller N makes no angle
ASYMMETRY = 0.05  # difference of the walls' forces, relative to their mean, from which on each wall is drawn

FORCES = {
    "P": "bottom force P (kN/m)",
    "T": "wall friction force T (kN/m)",
    "N": "wall normal force N (kN/m)",
}
ANGLE = r"wall friction angle $\varphi_w$ = arctan(T/N) (°)"


def by_void_ratio(runs: list[Result]) -> list[list[Result]]:
    """The runs in groups of equal initial void ratio, densest first."""
    groups = {}
    for run in runs:
        groups.setdefault(round(run.scene.sand.void_ratio, 3), []).append(run)
    return [groups[void_ratio] for void_ratio in sorted(groups)]


def angle(rows):
    """Wall friction angle [degrees] of rows of `forces.csv`; nan while the walls carry less than 1 % of the weight."""
    known = rows["N"] > LEAST_SHARE * rows["weight_N_per_m"]
    return np.where(known, rows["wall_friction_angle_deg"], np.nan)


def run_forces_figure(run):
    """Return the figure of P, T and N of one run, or None without data."""
    if run.forces.empty:
        return None
    figure = new_figure(11.0, 4.6)
    panels = dict(zip(FORCES, figure.subplots(1, 3), strict=True))
    for (name, panel), color in zip(panels.items(), (BLUE, VERMILLION, GREEN), strict=True):
        _curve(panel, run, lambda rows, name=name: rows[name] / 1e3, color, "median", raw_label="every row")
        if name != "P":
            _each_wall(panel, run, name, color)
        if run.scene.walls.kind != "very-rough":
            _janssen_line(panel, run, name)
        panel.set_ylabel(FORCES[name])
        x_axis(panel, [run])
        start_at_zero([panel], "y")
    origin = "T, N: mean of both walls"
    if run.filled is not None:
        origin += f"; weight W = {run.filled['weight_N_per_m'] / 1e3:.3g} kN/m"
    put_title(figure, f"Forces per metre run: {title(run)}", origin)
    _legend_below(figure, max(panels.values(), key=lambda panel: len(panel.get_lines())), columns=6)
    return figure


def run_angle_figure(run):
    """Return the figure of the wall friction angle of one run, or None without data."""
    if run.forces.empty:
        return None
    figure = new_figure(7.5, 5.2)
    panel = figure.subplots()
    _curve(panel, run, angle, BLUE, "median", raw_label="every row")
    _reference_angle(panel, run)
    words = textwrap.fill(title(run).replace(" mm", "\u00a0mm"), 88)  # no line may begin with a unit
    panel.set_title(f"Mobilised wall friction\n{words}", fontsize=11)
    panel.set_ylabel(ANGLE)
    x_axis(panel, [run])
    start_at_zero([panel], "y")
    _legend_below(figure, panel, columns=2)
    return figure


def case_forces_figure(runs):
    """Return the figure of P, T and N of several runs, one column for each initial void ratio."""
    groups = _drawable(runs)
    if not groups:
        return None
    figure = new_figure(1.2 + 5.4 * len(groups), 11.5)
    panels = figure.subplots(3, len(groups), squeeze=False, sharex="col", sharey="row")
    for column, group in enumerate(groups):
        for row, (name, label) in enumerate(FORCES.items()):
            panel = panels[row, column]
            for run, color in zip(group, line_colors(group), strict=True):
                _curve(panel, run, lambda rows, name=name: rows[name] / 1e3, color, run.label)
                if run.scene.walls.kind != "very-rough":
                    _janssen_line(panel, run, name)
            if column == 0:
                panel.set_ylabel(label)
        panels[0, column].set_title(_group_title(column, group))
        _legend_under(panels[2, column])
        x_axis(panels[2, column], group)
    for row in panels:
        start_at_zero(row, "y")
    figure.suptitle("Forces per metre run\nT, N: mean of both walls; marker: end of filling")
    return figure


def case_angles_figure(runs):
    """Return the figure of the wall friction angle of several runs, one panel for each initial void ratio."""
    groups = _drawable(runs)
    if not groups:
        return None
    figure = new_figure(1.2 + 5.4 * len(groups), 5.4)
    panels = figure.subplots(1, len(groups), squeeze=False, sharey=True)[0]
    for column, (panel, group) in enumerate(zip(panels, groups, strict=True)):
        for run, color in zip(group, line_colors(group), strict=True):
            _curve(panel, run, angle, color, run.label)
            _reference_angle(panel, run)
        if column == 0:
            panel.set_ylabel(ANGLE)
        panel.set_title(_group_title(column, group))
        _legend_under(panel)
        x_axis(panel, group)
    start_at_zero(panels, "y")
    figure.suptitle("Mobilised wall friction (marker: end of filling)")
    return figure


def _drawable(runs):
    return by_void_ratio([run for run in runs if not run.forces.empty])


def _group_title(column: int, group) -> str:
    return f"{chr(65 + column)}) {sand_title(group[0].scene.sand)}"


def _curve(panel, run, quantity, color, label, raw_label=None):
    """Draw every row as a light line, its running median on top, and the state after filling as a marker.

    A run without flow is drawn against the time of its filling.
    """
    flowing = not run.flow.empty
    rows = run.flow if flowing else run.filling
    x = 1e3 * rows["displacement_m"] if flowing else rows["time_s"]
    y = pd.Series(quantity(rows), index=rows.index)
    panel.plot(x, y, color=color, alpha=0.35, linewidth=0.6, label=raw_label)
    panel.plot(x, running_median(x, y), color=color, label=_median_label(label, x) if raw_label else label)
    if run.filled is not None:
        at_rest = 0.0 if flowing else x.iloc[-1]
        panel.plot(
            at_rest,
            quantity(run.filled),
            "o",
            color=color,
            markeredgecolor="white",
            markersize=9,
            clip_on=False,
            zorder=4,
            label=("end of filling" if flowing else "last state") if raw_label else None,
        )


def _each_wall(panel, run, name: str, color):
    """Draw the medians of the left and the right wall's force where they differ."""
    rows = run.flow
    if rows.empty:
        return
    part = "shear" if name == "T" else "normal"
    walls = {wall: rows[f"{wall}_{part}_N_per_m"] / 1e3 for wall in ("left", "right")}
    if abs(walls["left"].mean() - walls["right"].mean()) < ASYMMETRY * abs(rows[name].mean() / 1e3):
        return
    x = 1e3 * rows["displacement_m"]
    for (wall, y), line in zip(walls.items(), ("-.", ":"), strict=True):
        median = running_median(x, y)
        few = slice(None, None, 1 + len(x) // 200)  # dots and dashes need a line without jitter
        panel.plot(x[few], median[few], color=color, linestyle=line, linewidth=1.8, label=f"{wall} wall")


def _window(x) -> float:
    return SMOOTHING * (x.iloc[-1] - x.iloc[0])


def _median_label(label: str, x) -> str:
    return f"{label} over {_window(x):.2g} {'mm' if x.name == 'displacement_m' else 's'}"


def running_median(x, y) -> pd.Series:
    """Return the running median over a centred window of constant width in x, which narrows at the start.

    A one-sided window would hide the steep change of the forces as the bottom begins to move.
    """
    step = np.median(np.diff(x)) if len(x) > 1 else 0.0
    half = int(round(0.5 * _window(x) / step)) if step > 0.0 else 0
    median = y.rolling(2 * half + 1, center=True, min_periods=1).median()
    for row in range(min(half, len(y) // 2)):
        median.iloc[row] = y.iloc[: 2 * row + 1].median()
    return median


def _janssen_line(panel, run, name: str):
    """Draw Janssen's force as a dashed line."""
    origin, ratio = next(iter(theory.pressure_ratios(run).items()))
    fill = theory.janssen(run, ratio)
    if fill is None:
        return
    value = {
        "P": fill.bottom_force_N_per_m,
        "T": fill.shear_force_N_per_m,
        "N": fill.normal_force_N_per_m,
    }[name]
    _reference_line(panel, value / 1e3, "--", f"Janssen, {origin} = {ratio:.2f}")


def _reference_angle(panel, run):
    """Draw the friction angle of the wall, or of critical simple shear along a very rough one."""
    reference, rough = theory.wall_angle_deg(run), run.scene.walls.kind == "very-rough"
    name = "critical simple shear" if rough else "wall friction"
    _reference_line(panel, reference, ":" if rough else "--", f"{name}, {reference:.3g}°")


def _reference_line(panel, value: float, line: str, label: str):
    panel.axhline(value, color=REFERENCE, linestyle=line, linewidth=1.6, zorder=3.5, label=label)


def x_axis(panel, group):
    """Label the axis that runs share: the bottom displacement, or the time while none of them has flowed."""
    if all(run.flow.empty for run in group):
        panel.set_xlabel("time while filling (s)")
        panel.set_xlim(left=0.0)
    else:
        last = max(run.flow["displacement_m"].max() for run in group if not run.flow.empty)
        what = "bottom" if all(run.scene.silo.floor_is_outlet for run in group) else "outlet"
        panel.set_xlabel(f"displacement u of the {what} (mm)")
        if last > 0.0:
            panel.set_xlim(0.0, 1e3 * last)
    panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _legend_below(figure, panel, columns: int):
    """Put a panel's legend below the figure."""
    handles, labels = panel.get_legend_handles_labels()
    legend = figure.legend(handles, labels, loc="outside lower center", ncols=min(columns, len(labels)))
    for line in legend.get_lines():  # the light line of every row is too thin to be seen as a sample
        line.set_linewidth(max(line.get_linewidth(), 1.6))


def _legend_under(panel):
    """Put a panel's legend below its x axis."""
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2)
