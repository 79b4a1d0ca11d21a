"""Forces on bottom and walls, and the wall friction angle, against the bottom displacement (Fig. 10, 11)."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from taichi_silo.runs.inclined_walls import of_which
from taichi_silo.runs.result import Result
from taichi_silo.show import theory
from taichi_silo.show.figures.style import (
    BLUE,
    GREEN,
    REFERENCE,
    VERMILLION,
    legend_below,
    new_figure,
    put_title,
    start_at_zero,
)
from taichi_silo.show.report.words import kN, length_unit
from taichi_silo.show.titles import title

SMOOTHING = 0.005  # window of the median lines, as a fraction of the whole displacement
LEAST_SHARE = 0.01  # of the weight: a smaller N makes no angle
ASYMMETRY = 0.05  # difference of the walls' forces, relative to their mean, from which on each wall is drawn

FORCES = {"P": "bottom force P (kN/m)", "T": "wall friction force T (kN/m)", "N": "wall normal force N (kN/m)"}
ANGLE = r"wall friction angle $\varphi_w$ = arctan(T/N) (°)"


def angle(rows):
    """Wall friction angle [degrees] of rows of `forces.csv`; nan while the walls carry less than 1 % of the weight."""
    known = rows["N"] > LEAST_SHARE * rows["weight_N_per_m"]
    return np.where(known, rows["wall_friction_angle_deg"], np.nan)


def run_forces_figure(run: Result) -> Figure | None:
    """Figure of P, T and N of one run, or None without data."""
    if run.forces.empty:
        return None
    figure = new_figure(11.0, 4.6)
    panels = dict(zip(FORCES, figure.subplots(1, 3), strict=True))
    for (name, panel), color in zip(panels.items(), (BLUE, VERMILLION, GREEN), strict=True):
        draw_curve(panel, run, lambda rows, name=name: rows[name] / 1e3, color, "median", "every row")
        if name != "P" and theory.straight_m(run):
            _each_wall(panel, run, name, color)
        if run.scene.walls.kind != "very-rough":
            janssen_line(panel, run, name)
        panel.set_ylabel(FORCES[name])
        x_axis(panel, [run])
        start_at_zero([panel], "y")
    origin = of_which(run.scene.silo)
    if run.filled is not None:
        origin += f"; weight W = {kN(run.filled['weight_N_per_m'])} kN/m"
    put_title(
        figure, f"Forces per metre {'of girth' if run.scene.silo.section == 'round' else 'run'}: {title(run)}", origin
    )
    _legend_below(figure, max(panels.values(), key=lambda panel: len(panel.get_lines())), columns=6)
    return figure


def run_angle_figure(run: Result) -> Figure | None:
    """Figure of the wall friction angle of one run, or None without data."""
    if run.forces.empty or not theory.straight_m(run):
        return None
    figure = new_figure(7.5, 5.2)
    panel = figure.subplots()
    draw_curve(panel, run, angle, BLUE, "median", raw_label="every row")
    reference_angle(panel, run)
    put_title(figure, "Mobilised wall friction", title(run))
    panel.set_ylabel(ANGLE)
    x_axis(panel, [run])
    start_at_zero([panel], "y")
    _legend_below(figure, panel, columns=2)
    return figure


def draw_curve(panel, run: Result, quantity, color, label, raw_label=None):
    """Draw every row as a light line, its running median on top, and the state after filling as a marker.

    A run without flow is drawn against the time of its filling.
    """
    flowing = not run.flow.empty
    rows = run.flow if flowing else run.filling
    unit, per_m = displacement_unit([run])
    x = per_m * rows["displacement_m"] if flowing else rows["time_s"]
    y = pd.Series(quantity(rows), index=rows.index)
    panel.plot(x, y, color=color, alpha=0.35, linewidth=0.6, label=raw_label)
    window = f" over {_window(x):.2g} {unit if flowing else 's'}" if raw_label else ""
    panel.plot(x, running_median(x, y), color=color, label=f"{label}{window}")
    if run.filled is not None:
        panel.plot(
            0.0 if flowing else x.iloc[-1], quantity(run.filled), "o", color=color, markeredgecolor="white",
            markersize=9, clip_on=False, zorder=4,
            label=("end of filling" if flowing else "last state") if raw_label else None,
        )  # fmt: skip


def _each_wall(panel, run: Result, name: str, color):
    """Draw the medians of the left and the right wall's force where they differ."""
    rows = run.flow
    if rows.empty:
        return
    part = "shear" if name == "T" else "normal"
    walls = {wall: rows[f"{wall}_{part}_N_per_m"] / 1e3 for wall in ("left", "right")}
    if abs(walls["left"].mean() - walls["right"].mean()) < ASYMMETRY * abs(rows[name].mean() / 1e3):
        return
    x = displacement_unit([run])[1] * rows["displacement_m"]
    for (wall, y), line in zip(walls.items(), ("-.", ":"), strict=True):
        median = running_median(x, y)
        few = slice(None, None, 1 + len(x) // 200)  # dots and dashes need a line without jitter
        panel.plot(x[few], median[few], color=color, linestyle=line, linewidth=1.8, label=f"{wall} wall")


def _window(x) -> float:
    return SMOOTHING * (x.iloc[-1] - x.iloc[0])


def running_median(x, y) -> pd.Series:
    """The running median over a centred window of constant width in x, which narrows at the start.

    A one-sided window would hide the steep change of the forces as the bottom begins to move.
    """
    step = np.median(np.diff(x)) if len(x) > 1 else 0.0
    half = int(round(0.5 * _window(x) / step)) if step > 0.0 else 0
    median = y.rolling(2 * half + 1, center=True, min_periods=1).median()
    for row in range(min(half, len(y) // 2)):
        median.iloc[row] = y.iloc[: 2 * row + 1].median()
    return median


def curve(run: Result, name: str, place: str = "displacement_m") -> tuple[np.ndarray, np.ndarray]:
    """Places and values [N/m, or degrees] of a run's curve: the state after filling, then the flow's running median.

    `name` is P, T, N, a wall's force such as left_normal, or angle; `place` "displacement_m", or "time_s" since the
    outflow began.
    """
    rows = run.flow
    if rows.empty:
        return np.zeros(0), np.zeros(0)
    begin = 0.0
    if place == "time_s":
        begin = run.filling["time_s"].iloc[-1] if len(run.filling) else rows["time_s"].iloc[0]
    x, y = rows[place] - begin, pd.Series(_values(rows, name), index=rows.index)
    y = running_median(x, y)
    x, y = x.to_numpy(float), y.to_numpy(float)
    if run.filled is not None and x[0] > 0.0:
        x, y = np.append(0.0, x), np.append(float(_values(run.filled, name)), y)
    known = np.isfinite(y)
    return x[known], y[known]


def _values(rows, name: str):
    """P, T, N, angle, or a wall's force by its name without the unit, of rows of `forces.csv`."""
    if name == "angle":
        return angle(rows)
    return rows[name if name in ("P", "T", "N") else f"{name}_N_per_m"]


def janssen_line(panel, run: Result, name: str):
    """Draw Janssen's force as a dashed line."""
    origin, ratio = next(iter(theory.pressure_ratios(run).items()))
    fill, silo = theory.janssen(run, ratio), run.scene.silo
    if fill is None or (name == "P" and silo.transition_m):  # it carries a floor, and there is none
        return
    if name != "P" and silo.one_sided:  # the theory counts both walls above the higher foot; the report has each wall
        return
    girths = 2 if silo.section == "round" else 1  # metres of girth that P is counted for
    value = {"P": girths * fill.bottom_force_N_per_m, "T": fill.shear_force_N_per_m, "N": fill.normal_force_N_per_m}[
        name
    ]
    _reference_line(panel, value / 1e3, "--", f"Janssen, {origin} = {ratio:.2f}")


def reference_angle(panel, run: Result):
    """Draw the friction angle of the wall, or of critical simple shear along a very rough one."""
    reference, rough = theory.wall_angle_deg(run), run.scene.walls.friction_angle_deg is None
    name = "critical simple shear" if rough else "wall friction"
    _reference_line(panel, reference, ":" if rough else "--", f"{name}, {reference:.3g}°")


def _reference_line(panel, value: float, line: str, label: str):
    panel.axhline(value, color=REFERENCE, linestyle=line, linewidth=1.6, zorder=3.5, label=label)


def displacement_unit(group) -> tuple[str, float]:
    """Unit in which the displacements of runs are drawn, and how many of it make a metre."""
    return length_unit(max((run.flow["displacement_m"].max() for run in group if not run.flow.empty), default=0.0))


def x_axis(panel, group):
    """Label the axis that runs share: the bottom displacement, or the time while none of them has flowed."""
    if all(run.flow.empty for run in group):
        panel.set_xlabel("time while filling (s)")
        panel.set_xlim(left=0.0)
    else:
        last = max(run.flow["displacement_m"].max() for run in group if not run.flow.empty)
        moves = "run-out of the front" if all(run.scene.flow.outflow == "collapse" for run in group) else ""
        what = "bottom" if all(run.scene.silo.floor_is_outlet for run in group) else "outlet"
        unit, per_m = displacement_unit(group)
        panel.set_xlabel(f"{moves or f'displacement u of the {what}'} ({unit})")
        if last > 0.0:
            panel.set_xlim(0.0, per_m * last)
    panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))


def _legend_below(figure, panel, columns: int):
    """Put a panel's legend below the figure."""
    handles, labels = panel.get_legend_handles_labels()
    legend = legend_below(figure, handles, labels, columns)
    for line in legend.get_lines() if legend else ():  # the light line of every row is too thin to be seen as a sample
        line.set_linewidth(max(line.get_linewidth(), 1.6))
