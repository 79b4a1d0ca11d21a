"""Figures of a study of convergence: numbers against the size of the cells, and their errors against what they cost."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLUE, COLORS, REFERENCE, make_logarithmic, new_figure

PANELS = (
    ("P_filled", "T_filled", "N_filled"),
    ("P_residual", "T_residual", "N_residual"),
    ("TN_residual", "pressure_residual_0.5", "zone_thickness"),
)  # rows of the figure, of what there is
TITLES = {
    "P_filled": "P after filling", "T_filled": "T after filling", "N_filled": "N after filling",
    "P_residual": "P at the end", "T_residual": "T at the end", "N_residual": "N at the end",
    "TN_residual": "T/N at the end", "pressure_residual_0.5": "wall stress at mid-height, at the end",
    "zone_thickness": "thickness of the wall zone",
}  # fmt: skip
UNITS = {"N/m": ("kN/m", 1e-3), "Pa": ("kPa", 1e-3), "m": ("mm", 1e3), "-": ("", 1.0)}
ROUND_OFF = 1e-6  # below which an error is drawn there, and has no digit that counts


def shown_in(unit: str) -> tuple[str, float]:
    """Unit in which a quantity is shown, and its number in the SI unit."""
    return UNITS.get(unit, (unit, 1.0))


def convergence_figure(found: tuple[pd.DataFrame, pd.DataFrame]) -> Figure | None:
    """Numbers of all runs against the size of their cells, with the bands that hold their limits.

    `found` are the runs and the numbers, as `runs.csv` and `converge.csv` of the study have them.
    """
    runs, numbers = found[0], found[1].set_index("quantity")
    rows = [names for names in ([one for one in row if one in numbers.index] for row in PANELS) if names]
    if not rows:
        return None
    wide = max(map(len, rows))
    figure = new_figure(4.0 * wide, 3.3 * len(rows))
    panels = figure.subplots(len(rows), wide, squeeze=False)
    for number, names in enumerate(rows):
        for panel, name in zip(panels[number], [*names, *[None] * wide][:wide], strict=True):
            _values(panel, runs, numbers, name) if name else panel.set_visible(False)
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def _values(panel, runs: pd.DataFrame, numbers: pd.DataFrame, name: str) -> None:
    """One number against the size of the cells."""
    number = numbers.loc[name]
    unit, factor = shown_in(number["unit"])
    main = runs[runs["main"]].sort_values("cell_size_m")
    slow = runs["speed_m_per_s"] == main["speed_m_per_s"].min()
    others = runs[~runs["main"] & slow]
    value, error = factor * number["value"], factor * number["error"]
    if np.isfinite(error):
        panel.axhspan(value - error, value + error, color=BLUE, alpha=0.13, lw=0, label="band that holds the limit")
    panel.axhline(value, color=BLUE, lw=1.2, ls=(0, (5, 3)), label="extrapolated")
    panel.plot(1e3 * main["cell_size_m"], factor * main[name], "o-", color=BLUE, label="computed")
    if len(others):
        panel.plot(1e3 * others["cell_size_m"], factor * others[name], "o", mfc="white", color=REFERENCE,
                   label="with the length of the step before")  # fmt: skip
    panel.set_xlim(0.0, 1.05e3 * main["cell_size_m"].max())
    low, high = panel.get_ylim()
    if high - low < 1e2 * ROUND_OFF * abs(value):  # runs that differ by round-off are alike
        panel.set_ylim(sorted((0.99 * value, 1.01 * value)))
    panel.ticklabel_format(axis="y", useOffset=False)
    panel.set_title(TITLES[name])
    panel.set_xlabel("size of the cells (mm)")
    panel.set_ylabel(unit)


def cost_figure(found: tuple[pd.DataFrame, pd.DataFrame]) -> Figure | None:
    """Distance of the forces from their limits against what the runs cost, with the errors of the limits themselves."""
    runs, numbers = found[0], found[1].set_index("quantity")
    main = runs[runs["main"]].sort_values("core_seconds")
    panels_of = [[name for name in row if name in numbers.index] for row in PANELS[:2]]
    panels_of = [names for names in panels_of if names]
    if not panels_of or len(main) < 2:
        return None
    figure = new_figure(5.6 * len(panels_of), 4.4)
    panels = figure.subplots(1, len(panels_of), squeeze=False, sharey=True)[0]
    for panel, names in zip(panels, panels_of, strict=True):
        for colour, name in zip(COLORS, names, strict=False):
            number = numbers.loc[name]
            measure = number["error"] / number["relative_error"] if number["relative_error"] else np.nan
            errors = (main[name] - number["value"]).abs() / measure
            panel.plot(main["core_seconds"], 100.0 * np.maximum(errors, ROUND_OFF), "o-", color=colour, label=name[0])
            panel.axhline(100.0 * max(number["relative_error"], ROUND_OFF), color=colour, lw=1.0, ls=(0, (5, 3)))
        panel.set_title(TITLES[names[0]].replace("P ", "forces "))
        panel.set_xlabel("cost of the run (core-seconds)")
    for axis in (*(panel.xaxis for panel in panels), *(panel.yaxis for panel in panels)):
        make_logarithmic(axis)
    panels[0].set_ylabel("distance from the limit, % of the weight")
    panels[0].legend(title="dashed: error of the limit")
    return figure


FIGURES = {"convergence": convergence_figure, "cost": cost_figure}
