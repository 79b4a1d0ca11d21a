"""Runs laid over each other: P, T, N and wall angle against displacement or time, and wall stresses against height."""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from taichi_silo.runs.result import Result
from taichi_silo.show.figures import draw_all
from taichi_silo.show.figures.forces import ANGLE, FORCES, curve, displacement_unit
from taichi_silo.show.figures.style import COLORS, REFERENCE, legend_below, new_figure, start_at_zero
from taichi_silo.show.figures.wall_stress import STATES, STRESSES
from taichi_silo.show.report.states import FORCES as KEYS
from taichi_silo.show.report.states import reading_of, wall_profile
from taichi_silo.show.report.words import length_unit, mm
from taichi_silo.show.theory import janssen, pressure_ratios, wall_angle_deg

LINES = ("-", (0, (5, 1.5)), (0, (1, 1)))  # from the eighth run on colours come again with another line
LABELS = FORCES | {"angle": ANGLE}
WALL_FORCES = {"left_normal": "N", "right_normal": "N", "left_shear": "T", "right_shear": "T"}
DOTTED = {"linestyle": ":", "linewidth": 1.3, "zorder": 1}
MARKS = {"left": "<", "right": ">"}


def plot_compared(runs: list[Result], measured: list, with_janssen: bool, target: Path) -> list[Path]:
    """Draw `compare_forces.png` and `compare_walls.png` into a folder, and return the paths of those that have data.

    `measured` are `studies.compare.measured.Measured`; Janssen's theory is at the law's own pressure ratio.
    """
    figures = {
        "compare_forces": lambda runs: forces_figure(runs, measured, with_janssen),
        "compare_walls": lambda runs: walls_figure(runs, measured, with_janssen),
    }
    return draw_all(figures, runs, target)


def forces_figure(runs: list[Result], measured: list, with_janssen: bool) -> Figure | None:
    """Four panels, or None if nothing has flowed.

    They are drawn over what measured curves are given over; without any, over displacements, or over times since the
    outflow began if a run falls freely.
    """
    curves = [one for one in measured if one.kind == "curves"]
    place = curves[0].place if curves else "time_s" if any(run.free for run in runs) else "displacement_m"
    time = place == "time_s"
    figure = new_figure(12.5, 8.6 + 0.26 * len(runs))
    panels, scale, last = dict(zip(LABELS, figure.subplots(2, 2).ravel(), strict=True)), 1.0, 0.0
    unit_of_u, per_m = displacement_unit(runs)
    scale = scale if time else per_m
    for name, panel in panels.items():
        unit = 1.0 if name == "angle" else 1e-3
        for number, run in enumerate(runs):
            places, values = curve(run, name, place)
            panel.plot(scale * places, unit * values, label=run.label, **_look(number))
            last = max(last, scale * places[-1]) if len(places) else last
            expected = _janssen_force(run, name) if with_janssen else None
            if expected is not None:
                panel.axhline(unit * expected, color=_look(number)["color"], **DOTTED)
        for one in curves:
            for quantity in one.quantities:
                if WALL_FORCES.get(quantity, quantity) == name:
                    places, values = one.table[[place, quantity]].dropna().to_numpy(float).T
                    side = quantity.partition("_")[0] if quantity in WALL_FORCES else ""
                    label = f"{one.name}, {side} wall" if side else one.name
                    _points(panel, scale * places, unit * values, label, MARKS.get(side, "o"))
        panel.set_ylabel(LABELS[name])
        panel.set_xlabel(
            "time since the outflow began (s)" if time else f"displacement u of bottom or gate ({unit_of_u})"
        )
        panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        panel.set_xlim(0.0, last or None)
        start_at_zero([panel], "y")
    if not last:
        return None
    words = "T, N: mean of both walls; running median"
    figure.suptitle(f"Forces per metre run\n{words}{'; dotted: Janssen, after filling' if with_janssen else ''}")
    _legend(figure, panels.values())
    return figure


def walls_figure(runs: list[Result], measured: list, with_janssen: bool) -> Figure | None:
    """Normal stresses above, shear stresses below, a column for each state; None without any profile.

    Of a silo whose outlet is off the middle both walls are drawn, else their mean.
    """
    sides = {run.label: ("left", "right") if run.lopsided else ("both",) for run in runs}
    states = [state for state in STATES if any(len(wall_profile(run, state)[0]) for run in runs)]
    if not states:
        return None
    figure = new_figure(1.5 + 4.0 * len(states), 9.6 + 0.26 * len(runs))
    panels = figure.subplots(2, len(states), squeeze=False, sharey=True, sharex="row")
    highest = max(run.scene.silo.height_m for run in runs)
    unit, per_m = length_unit(highest)
    for row, (column, words) in zip(panels, STRESSES.items(), strict=True):
        for state, panel in zip(states, row, strict=True):
            for number, run in enumerate(runs):
                look = _look(number)
                for wall in sides[run.label]:
                    heights, stresses = wall_profile(run, state, column, wall)
                    other = {"linestyle": "--", "label": None} if wall == "right" else {"label": run.label}
                    panel.plot(1e-3 * stresses, per_m * heights, **(look | other))
                ratio = next(iter(pressure_ratios(run).values()))
                if with_janssen and state == "filling" and (fill := janssen(run, ratio)) is not None:
                    depth = np.linspace(0.0, fill.height_m, 101)
                    law = fill.normal_stress_Pa if column == "normal_stress_Pa" else fill.shear_stress_Pa
                    heights = run.scene.silo.height_m - depth
                    panel.plot(1e-3 * law(depth), per_m * heights, color=look["color"], **DOTTED)
            for name, wall, heights, stresses in _measured_profiles(measured, state, column):
                label = name if wall == "both" else f"{name}, {wall}"
                _points(panel, 1e-3 * stresses, per_m * heights, label, MARKS.get(wall, "o"))
            panel.set_xlabel(words)
        start_at_zero(row, "x")
        row[0].set_ylabel(f"height above the initial bottom ({unit})")
    for state, panel in zip(states, panels[0], strict=True):
        panel.set_title(STATES[state][2])
    panels[0, 0].set_ylim(top=1.05 * per_m * highest)
    cells = " or ".join(dict.fromkeys(mm(reading_of(run).cell_m) for run in runs))
    words = f"as a pressure cell of {cells} reads; mean of both walls"
    if any(run.lopsided for run in runs):
        words += "; outlet off the middle: left wall solid, right wall dashed"
    figure.suptitle(f"Wall stresses\n{words}{'; dotted: Janssen' if with_janssen else ''}")
    _legend(figure, panels.ravel())
    return figure


def _janssen_force(run: Result, name: str) -> float | None:
    """Janssen's P, T or N [N/m] at the law's own pressure ratio, or the angle of smooth walls [degrees]."""
    if name == "angle":
        return wall_angle_deg(run) if run.scene.walls.kind == "smooth" else None
    if name != "P" and run.scene.silo.one_sided:  # the curve is of whole walls, the theory of what both have
        return None
    return (run.summary.get("janssen") or {}).get(f"{KEYS[name][0]}_K0")


def _measured_profiles(measured: list, state: str, column: str) -> Iterator[tuple]:
    """Name of the file, wall, heights and stresses of the measured profiles of a state, or of no named state."""
    for one in measured:
        if one.kind == "profile" and column in one.table:
            for (found, wall), rows in one.table.groupby(["state", "wall"], sort=False):
                if found in ("", state):
                    yield one.name, wall, *rows[["height_m", column]].dropna().to_numpy(float).T


def _look(number: int) -> dict:
    """Colour and line of a run; the first is wide, so that it shows below one that is equal."""
    line = LINES[number // len(COLORS) % len(LINES)]
    return {"color": COLORS[number % len(COLORS)], "linestyle": line, "linewidth": 1.8 if number else 3.4}


def _points(panel, x, y, label: str, mark: str) -> None:
    """Draw measurements, so many that each can be seen."""
    panel.plot(
        x, y, mark, color=REFERENCE, markersize=6, markerfacecolor="none", markeredgewidth=1.3, label=label, zorder=4,
        markevery=max(1, len(np.atleast_1d(x)) // 40),
    )  # fmt: skip


def _legend(figure, panels) -> None:
    """One legend below the panels, of all their labels, each once."""
    found = [zip(*reversed(panel.get_legend_handles_labels()), strict=True) for panel in panels]
    handles: dict[str, Any] = dict(itertools.chain.from_iterable(found))
    legend_below(figure, handles.values(), handles, 2 if len(handles) > 3 else 1)
