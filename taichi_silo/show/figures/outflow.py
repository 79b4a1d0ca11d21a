"""Mass and rate of what leaves by each of several outlets."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from taichi_silo.runs.observers.outflow import columns_of
from taichi_silo.runs.result import Result
from taichi_silo.show.figures.style import COLORS, new_figure, put_title, start_at_zero
from taichi_silo.show.titles import title

WINDOW = 0.02  # of the outflow, over which a rate is a mean
WIDER = 1.4  # points by which a line is wider than the one over it: what outlets let out alike is seen of each


def run_outflow_figure(run: Result) -> Figure | None:
    """Figure of one run, or None where there is one outlet, whose mass `forces.csv` has."""
    rows = run.outflow
    rows = rows[rows["stage"] == "flow"]
    if len(rows) < 2:
        return None
    figure = new_figure(9.6, 4.6)
    masses, rates = figure.subplots(1, 2)
    begun = run.filling["time_s"].iloc[-1] if len(run.filling) else rows["time_s"].iloc[0]
    time = rows["time_s"].to_numpy(float) - begun
    outlets = run.scene.silo.outlets
    for number, outlet in enumerate(outlets):
        opened, mass, *_ = columns_of(number + 1)
        color, label = COLORS[number % len(COLORS)], f"{number + 1}: {outlet.words()}"
        width = 2.0 + WIDER * min(len(outlets) - 1 - number, 3)
        masses.plot(time, rows[mass], color=color, label=label, linewidth=width)
        rates.plot(time, mean_rate(time, rows[mass].to_numpy(float)), color=color, linewidth=width)
        moving = rows[opened].to_numpy(float) > 0.0
        masses.plot(time[~moving], rows[mass][~moving], color="white", linewidth=0.8)
    masses.set_ylabel("mass that has left (kg/m)")
    rates.set_ylabel("rate (kg/s per m)")
    for panel in (masses, rates):
        panel.set_xlabel("time since the outflow began (s)")
        panel.set_xlim(0.0, time[-1])
        panel.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        start_at_zero([panel], "y")
    figure.legend(*masses.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    put_title(figure, f"Outflow: {title(run)}", "hollow: gate closed")
    return figure


def mean_rate(time_s: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Rate of a mass (n,) over a window about each time (n,); single points that leave would make it jagged."""
    half = 0.5 * WINDOW * (time_s[-1] - time_s[0])
    low, high = np.maximum(time_s - half, time_s[0]), np.minimum(time_s + half, time_s[-1])
    return (np.interp(high, time_s, mass) - np.interp(low, time_s, mass)) / np.maximum(high - low, 1e-12)
