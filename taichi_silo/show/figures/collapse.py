"""A column that has collapsed: its surface at several times, and how far its front has run."""

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from taichi_silo.runs.collapse_findings import first_length_m, history, profile_of
from taichi_silo.runs.result import Result
from taichi_silo.show.figures.style import BLUE, VERMILLION, new_figure, put_title
from taichi_silo.show.report.words import length_unit
from taichi_silo.show.titles import title

PROFILES = 7  # at most


def run_collapse_figure(run: Result) -> Figure | None:
    """Figure of one run; None where no column collapses, or before it does."""
    if run.scene.flow.outflow != "collapse" or not len(run.flow_states):
        return None
    unit, per_m = length_unit(run.scene.silo.height_m)
    figure = new_figure(11.0, 6.4)
    surface, course = figure.subplots(2, 1)
    table = history(run)
    filled = int(np.flatnonzero(run.snapshots.stage == "filling")[-1])
    over = np.flatnonzero(table.run_out_over_L0 >= 0.99 * table.run_out_over_L0.iloc[-1])[0]
    moving = filled + np.unique(np.linspace(0, over, PROFILES - 1).round().astype(int))
    chosen = np.unique([*moving, len(run.snapshots) - 1])
    colors = colormaps["viridis"](np.linspace(0.0, 0.9, len(chosen)))
    for number, color in zip(chosen, colors, strict=True):
        profile = profile_of(run.state(int(number)), run.scene)
        since = max(0.0, run.snapshots.time_s[number] - run.flow_start_s)
        there = profile.height_m > 0.0
        heights = np.where(there, profile.height_m, np.nan)
        surface.plot(per_m * profile.middle_m, per_m * heights, color=color, label=f"{since:.2f} s")
    surface.set(xlabel=f"x ({unit})", ylabel=f"height ({unit})", aspect="equal", ylim=(0.0, None))
    surface.set_xlim(0.0, per_m * run.scene.silo.width_m)
    surface.legend(title="time", loc="center left", bbox_to_anchor=(1.0, 0.5))
    course.plot(table.time_s, table.run_out_over_L0, color=BLUE, label="run-out (L − L₀) / L₀")
    course.plot(table.time_s, table.height_m / first_length_m(run.scene), color=VERMILLION, label="height H / L₀")
    course.set(xlabel="time since the walls were taken away (s)", ylim=(0.0, None), xlim=(0.0, None))
    course.legend()
    put_title(figure, f"Collapse: {title(run)}")
    return figure
