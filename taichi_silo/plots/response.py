"""What a sweep found against each quantity that varied, coloured by another one."""

import math
import re

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from taichi_silo.plots.style import BLUE, GREEN, ORANGE, PURPLE, REFERENCE, SKY, VERMILLION, new_figure, start_at_zero

WORDS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY)  # colours of values that are words
NUMBERS = "viridis"
BRIGHTEST = 0.88  # of that map; its yellow end is too pale for markers
WIDE = 20.0  # ratio of the largest to the least of at least three values, from which an axis is logarithmic
MOST_PANELS, ACROSS = 9, 3
UNITS = {
    "_m_per_s2": ("m/s²", 1.0), "_m_per_s": ("m/s", 1.0), "_kg_per_m3": ("kg/m³", 1.0), "_kg_per_m": ("kg/m", 1.0),
    "_N_per_m": ("kN/m", 1e-3), "_deg": ("°", 1.0), "_Pa": ("kPa", 1e-3), "_m": ("m", 1.0), "_s": ("s", 1.0),
}  # fmt: skip
FOUND = {
    "P": "bottom force P", "T": "wall friction force T", "N": "wall normal force N",
    "largest_wall_normal_stress_pressure_cell": "largest wall pressure on a 20 mm cell",
    "largest_wall_normal_stress_node": "largest wall pressure at a node",
    "largest_overpressure": "largest wall pressure over that after filling",
    "stagnant_area_share": "share of sand that stands still", "discharged": "sand that has left",
    "sand.name": "sand",
}  # fmt: skip
MOMENTS = {"filled": "after filling", "least": "least in flow", "largest": "largest in flow", "residual": "at the end"}


def response_figure(table: pd.DataFrame, varied: list[str], response) -> Figure | None:
    """Return a panel for each varied quantity, or None if no run has an answer yet.

    Parameters
    ----------
    table : rows of `sweep.csv`.
    varied : columns of what varied.
    response : its `y`; its `x`, which comes first; its `colour`.

    """
    known = table[table[response.y].notna()]
    if known.empty or not varied:
        return None
    columns = list(dict.fromkeys([response.x or varied[0], *varied]))[:MOST_PANELS]
    across = min(ACROSS, len(columns))
    down = math.ceil(len(columns) / across)
    figure = new_figure(2.2 + 5.2 * across, 0.9 + 4.3 * down)
    panels = figure.subplots(down, across, squeeze=False).flatten()
    for number, (x, panel) in enumerate(zip(columns, panels, strict=False)):
        others = [column for column in (*columns[number + 1 :], *columns[:number]) if column != x]
        colour = response.colour if response.colour not in (None, x) else next(iter(others), None)
        _panel(figure, panel, table, x, response.y, colour, [one for one in varied if one != x])
    for panel in panels[len(columns) :]:
        panel.set_visible(False)
    start_at_zero(panels[: len(columns)], "y")
    missing = len(table) - len(known)
    without = f", {missing} without an answer" if missing else ""
    figure.suptitle(f"{label(response.y)}: {len(table)} runs{without}", wrap=True)
    return figure


def label(column: str) -> str:
    """Of an axis, with its unit."""
    name, unit, _ = _parts(column)
    return f"{name} ({unit})"


def _parts(column: str) -> tuple[str, str, float]:
    """Name, unit, and factor from what the table holds."""
    suffix = next((suffix for suffix in UNITS if column.endswith(suffix)), "")
    unit, factor = UNITS.get(suffix, ("-", 1.0))
    plain = column.removesuffix(suffix)
    first, _, moment = plain.partition("_")
    if plain in FOUND:
        name = FOUND[plain]
    elif first in FOUND and moment in MOMENTS:
        name = f"{FOUND[first]} {MOMENTS[moment]}"
    else:
        *_, table, last = ["", "", *re.sub(r"\.(\d+)\.", r" \1.", plain).split(".")]
        name = table if last == "kind" else f"{table} {last}".strip()
    return name.replace("_", " "), unit, factor


def _panel(figure, panel, table: pd.DataFrame, x: str, y: str, colour: str | None, others: list[str]) -> None:
    """One quantity: runs that are alike in all others are joined."""
    places, ticks = _places(table[x], _parts(x)[2])
    answers = table[y] * _parts(y)[2]
    shades, legend = _shades(table[colour]) if colour is not None else ([BLUE] * len(table), [])
    if ticks is None and len(set(places)) > 1:
        groups = table.groupby(others, sort=False, dropna=False).indices.values() if others else [range(len(table))]
        for group in groups:
            line = sorted((k for k in group if not np.isnan(answers.iloc[k])), key=lambda k: places[k])
            if len(line) > 1:
                alike = len({str(shades[k]) for k in line}) == 1
                panel.plot(
                    [places[k] for k in line], answers.iloc[line], "-", zorder=1, linewidth=1.2,
                    color=shades[line[0]] if alike else REFERENCE, alpha=0.6,
                )  # fmt: skip
    there = answers.notna().to_numpy()
    panel.scatter(
        places[there], answers[there], s=46, color=[shades[k] for k in np.flatnonzero(there)], edgecolor="white",
        linewidth=0.7, zorder=2,
    )  # fmt: skip
    panel.set(xlabel=label(x) if ticks is None else _parts(x)[0], ylabel=label(y))
    if not there.all():
        low = panel.get_xaxis_transform()
        panel.plot(places[~there], np.full((~there).sum(), 0.03), "x", color=REFERENCE, transform=low, clip_on=False)
        legend = [*legend, Line2D([], [], marker="x", linestyle="", color=REFERENCE, label="no answer")]
    if ticks is not None:
        panel.set_xticks(range(len(ticks)), ticks)
        panel.set_xlim(-0.6, len(ticks) - 0.4)
    elif _wide(places):
        panel.set_xscale("log")
    if isinstance(legend, ScalarMappable):
        figure.colorbar(legend, ax=panel, label=label(colour), pad=0.02)
    elif legend:
        title = None if colour is None else label(colour) if _is_number(table[colour]) else _parts(colour)[0]
        panel.legend(
            handles=legend, title=title, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize=9.5,
            title_fontsize=9.5, alignment="left", borderaxespad=0.2, columnspacing=1.0, handletextpad=0.3,
        )  # fmt: skip


def _places(values: pd.Series, factor: float) -> tuple[np.ndarray, list[str] | None]:
    """Where they stand on an axis, and what is written there if they are words."""
    if _is_number(values):
        return values.to_numpy(float) * factor, None
    words = [_word(value) for value in values]
    known = list(dict.fromkeys(words))
    return np.array([known.index(word) for word in words], float), known


def _shades(values: pd.Series) -> tuple[list, list[Line2D] | ScalarMappable]:
    """A colour for each, and what explains them."""
    factor = _parts(str(values.name))[2]
    if _is_number(values):
        numbers = values.to_numpy(float) * factor
        known = sorted(set(numbers))
        norm = (LogNorm if _wide(numbers) else Normalize)(known[0], known[-1] if len(known) > 1 else known[0] + 1.0)
        few = len(known) <= len(WORDS)
        parts = {one: k / max(len(known) - 1, 1) if few else float(norm(one)) for k, one in enumerate(known)}
        shades = [colormaps[NUMBERS](BRIGHTEST * parts[one]) for one in numbers]
        if not few:
            part = colormaps[NUMBERS](np.linspace(0.0, BRIGHTEST, 256))
            return shades, ScalarMappable(norm, type(colormaps[NUMBERS]).from_list("part", part))
        return shades, [_dot(colormaps[NUMBERS](BRIGHTEST * parts[one]), f"{one:.4g}") for one in known]
    words = [_word(value) for value in values]
    known = dict(zip(dict.fromkeys(words), WORDS * (1 + len(words)), strict=False))
    return [known[word] for word in words], [_dot(shade, word) for word, shade in known.items()]


def _dot(color, words: str) -> Line2D:
    return Line2D([], [], marker="o", linestyle="", color=color, label=words)


def _is_number(values: pd.Series) -> bool:
    numbers = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
    return bool(numbers and values.notna().all())


def _wide(values: np.ndarray) -> bool:
    some = set(values)
    return len(some) > 2 and min(some) > 0.0 and max(some) >= WIDE * min(some)


def _word(value) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
