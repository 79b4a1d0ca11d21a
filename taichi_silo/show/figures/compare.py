"""Runs laid over each other: P, T, N and wall angle against displacement or time, and wall stresses against height."""

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.ticker import MaxNLocator

from taichi_silo.show.figures.forces import ANGLE, FORCES
from taichi_silo.show.figures.style import COLORS, REFERENCE, STYLE, new_figure, start_at_zero
from taichi_silo.show.figures.wall_stress import STATES, STRESSES
from taichi_silo.utils import atomic_write

LINES = ("-", (0, (5, 1.5)), (0, (1, 1)))  # from the eighth run on colours come again with another line
LABELS = FORCES | {"angle": ANGLE}
WALL_FORCES = {"left_normal": "N", "right_normal": "N", "left_shear": "T", "right_shear": "T"}
DOTTED = {"linestyle": ":", "linewidth": 1.3, "zorder": 1}
MARKS = {"left_normal": "<", "left_shear": "<", "right_normal": ">", "right_shear": ">"}


def save(figures: dict, target: Path) -> list[Path]:
    """Draw figures, functions by the names of their files, into a folder; return the files that have data."""
    written = []
    for name, make_figure in figures.items():
        with rc_context(STYLE):
            figure = make_figure()
            if figure is None:
                continue
            with atomic_write.written(target / name) as passing:
                figure.savefig(passing, format="png")
        written.append(target / name)
    return written


def compare_forces_figure(curves: dict, measured: list, theory: dict, time: bool):
    """Four panels, or None if nothing has flowed.

    Parameters
    ----------
    curves : of each run by its label: P, T, N [N/m] and angle [deg], each (places, values).
    measured : (name of the file, quantity, places, values) of measurements.
    theory : of each run by its label: P, T, N after filling by Janssen [N/m], and the wall's angle [deg]; or empty.
    time : whether places are times [s], else displacements [m].

    """
    if not any(len(places) for names in curves.values() for places, _ in names.values()):
        return None
    figure = new_figure(12.5, 8.6 + 0.26 * len(curves))
    panels = dict(zip(LABELS, figure.subplots(2, 2).ravel(), strict=True))
    scale = 1.0 if time else 1e3
    last = 0.0
    for name, panel in panels.items():
        unit = 1.0 if name == "angle" else 1e-3
        for number, (label, names) in enumerate(curves.items()):
            places, values = names[name]
            panel.plot(scale * places, unit * values, label=label, **_look(number))
            last = max(last, scale * places[-1]) if len(places) else last
            if (expected := theory.get(label, {}).get(name)) is not None:
                panel.axhline(unit * expected, color=_look(number)["color"], **DOTTED)
        for file, quantity, places, values in measured:
            if WALL_FORCES.get(quantity, quantity) == name:
                _points(panel, scale * places, unit * values, _named(file, quantity), MARKS.get(quantity, "o"))
        panel.set_ylabel(LABELS[name])
        panel.set_xlabel("time since the outflow began (s)" if time else "displacement u of bottom or gate (mm)")
        panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        panel.set_xlim(0.0, last or None)
        start_at_zero([panel], "y")
    words = "T, N: mean of both walls; running median"
    figure.suptitle("Forces per metre run\n" + words + ("; dotted: Janssen, after filling" if theory else ""))
    _legend(figure, panels.values())
    return figure


def compare_walls_figure(profiles: dict, measured: list, theory: dict, top_m: float):
    """Normal stresses above, shear stresses below, a column for each state; None without any profile.

    Parameters
    ----------
    profiles : of each run by its label: {(state, column of STRESSES): {wall: (heights [m], stresses [Pa])}}, the wall
        being "both" for their mean, or "left" and "right" where they are not alike.
    measured : (name of the file, state or "", column, wall, heights, stresses) of measurements.
    theory : of each run by its label: {column of STRESSES: (heights, stresses)} by Janssen after filling; or empty.
    top_m : height of the highest fill.

    """
    lines = {key: line for runs in profiles.values() for walls in runs.values() for key, line in walls.items()}
    states = [state for state in STATES if any(_known(runs[state, "normal_stress_Pa"]) for runs in profiles.values())]
    if not states:
        return None
    figure = new_figure(1.5 + 4.0 * len(states), 9.6 + 0.26 * len(profiles))
    panels = figure.subplots(2, len(states), squeeze=False, sharey=True, sharex="row")
    for row, (column, words) in zip(panels, STRESSES.items(), strict=True):
        for state, panel in zip(states, row, strict=True):
            for number, (label, runs) in enumerate(profiles.items()):
                for wall, (heights, stresses) in runs[state, column].items():
                    dashed = {"linestyle": "--"} if wall == "right" else {}
                    named = None if wall == "right" else label
                    panel.plot(1e-3 * stresses, 1e3 * heights, label=named, **(_look(number) | dashed))
                if state == "filling" and label in theory:
                    places, expected = theory[label][column]
                    panel.plot(1e-3 * expected, 1e3 * places, color=_look(number)["color"], **DOTTED)
            for file, one, name, wall, heights, stresses in measured:
                if name == column and one in ("", state):
                    mark = {"left": "<", "right": ">"}.get(wall, "o")
                    _points(
                        panel, 1e-3 * stresses, 1e3 * heights, f"{file}{'' if wall == 'both' else f', {wall}'}", mark
                    )
            panel.set_xlabel(words)
        start_at_zero(row, "x")
        row[0].set_ylabel("height above the initial bottom (mm)")
    for state, panel in zip(states, panels[0], strict=True):
        panel.set_title(STATES[state][2])
    panels[0, 0].set_ylim(top=1.05e3 * top_m)
    words = "as a pressure cell of 20 mm reads; mean of both walls"
    words += "; outlet off the middle: left wall solid, right wall dashed" if "right" in lines else ""
    figure.suptitle(f"Wall stresses\n{words}" + ("; dotted: Janssen" if theory else ""))
    _legend(figure, panels.ravel())
    return figure


def _known(walls: dict) -> bool:
    return any(len(heights) for heights, _ in walls.values())


def _look(number: int) -> dict:
    """Of a run; the first is wide, so that it shows below one that is equal."""
    line = LINES[number // len(COLORS) % len(LINES)]
    return {"color": COLORS[number % len(COLORS)], "linestyle": line, "linewidth": 1.8 if number else 3.4}


def _points(panel, x, y, label: str, mark: str) -> None:
    few = max(1, len(np.atleast_1d(x)) // 40)  # so many that each can be seen
    panel.plot(
        x, y, mark, color=REFERENCE, markersize=6, markerfacecolor="none", markeredgewidth=1.3, markevery=few,
        label=label, zorder=4,
    )  # fmt: skip


def _named(file: str, quantity: str) -> str:
    return f"{file}, {quantity.partition('_')[0]} wall" if quantity in WALL_FORCES else file


def _legend(figure, panels) -> None:
    handles = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2 if len(handles) > 3 else 1)
