"""What a sweep found against each quantity that varied, coloured by another one."""

import math
import re

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from taichi_silo.show.figures.style import BLUE, REFERENCE, WORDS, make_logarithmic, new_figure, start_at_zero
from taichi_silo.utils.messages import counted

NUMBERS = "viridis"
BRIGHTEST = 0.88  # of that map; its yellow end is too pale for markers
WIDE = 20.0  # ratio of the largest to the least of at least three values, from which an axis is logarithmic
MARK, MARKS = "o", ("o", "^", "s", "D")
DODGE = 0.5  # of the distance between two words on an axis
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
    """Return a panel for each varied column of a `sweep.csv`, `response.x` first; None if no run has an answer."""
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
    figure.suptitle(f"{label(response.y)}: {counted(len(table), 'run')}{without}", wrap=True)
    return figure


def label(column: str) -> str:
    """Label of an axis for a column of the sweep's table, with its unit."""
    name, unit, _ = _parts(column)
    return f"{name} ({unit})"


def _parts(column: str) -> tuple[str, str, float]:
    """Name and unit of a column, and the factor from the table's unit to that one."""
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
    """Draw the response against one varied quantity; runs of a grid that are alike in all others are joined."""
    places, ticks = _places(table[x], _parts(x)[2])
    answers = table[y].to_numpy(float) * _parts(y)[2]
    there = ~np.isnan(answers)
    shades, handles, bar = _shades(table[colour]) if colour is not None else ([BLUE] * len(table), [], None)
    if ticks is not None and colour is not None:  # beside each other, in the order of the colour
        places = places + DODGE * (_ranks(table[colour]) - 0.5)
    if ticks is None:
        groups = table.groupby(others, sort=False, dropna=False).indices.values() if others else [range(len(table))]
        for group in groups if min(map(len, groups)) > 1 else ():  # draws are alike by chance only
            _join(panel, sorted((k for k in group if there[k]), key=lambda k: places[k]), places, answers, shades)
    marks, outlines = _marks(table, [one for one in others if one != colour])
    for mark in dict.fromkeys(marks):
        some = [k for k in np.flatnonzero(there) if marks[k] == mark]
        panel.scatter(
            places[some], answers[some], s=46, marker=mark, color=[shades[k] for k in some], edgecolor="white",
            linewidth=0.7, zorder=2,
        )  # fmt: skip
    handles = [*handles, *outlines]
    panel.set(xlabel=label(x) if ticks is None else _parts(x)[0], ylabel=label(y))
    if not there.all():
        low = panel.get_xaxis_transform()
        panel.plot(places[~there], np.full((~there).sum(), 0.03), "x", color=REFERENCE, transform=low, clip_on=False)
        handles = [*handles, _mark(REFERENCE, "no answer", "x")]
    if ticks is not None:
        panel.set_xticks(range(len(ticks)), ticks)
        panel.set_xlim(-0.6, len(ticks) - 0.4)
    elif _wide(places):
        make_logarithmic(panel.xaxis)
    if bar is not None and colour is not None:
        figure.colorbar(bar, ax=panel, label=label(colour), pad=0.02)
    if handles:
        title = None
        if colour is not None and bar is None:
            title = label(colour) if _is_number(table[colour]) else _parts(colour)[0]
        panel.legend(
            handles=handles, title=title, ncols=3,
            loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=9.5, title_fontsize=9.5, alignment="left",
            borderaxespad=0.2, columnspacing=1.0, handletextpad=0.3,
        )  # fmt: skip


def _join(panel, line: list[int], places: np.ndarray, answers: np.ndarray, shades: list) -> None:
    """Draw a line through runs, grey if they differ in colour."""
    alike = len({str(shades[k]) for k in line}) == 1
    color = shades[line[0]] if alike else REFERENCE
    if len(line) > 1:
        panel.plot(places[line], answers[line], "-", zorder=1, linewidth=1.2, color=color, alpha=0.6)


def _places(values: pd.Series, factor: float) -> tuple[np.ndarray, list[str] | None]:
    """Places of a column's values on an axis, and the words written there if they are no numbers."""
    if _is_number(values):
        return values.to_numpy(float) * factor, None
    places, known = pd.factorize(values.map(_word, na_action=None))
    return places.astype(float), list(known)


def _shades(values: pd.Series) -> tuple[list, list[Line2D], ScalarMappable | None]:
    """A colour for each value of a column, and handles of a legend or a colour bar that explain them."""
    if not _is_number(values):
        words = [_word(value) for value in values]
        known = dict(zip(dict.fromkeys(words), WORDS * (1 + len(words)), strict=False))
        return [known[word] for word in words], [_mark(shade, word) for word, shade in known.items()], None
    numbers = values.to_numpy(float) * _parts(values.name)[2]
    steps, colours = sorted(set(numbers)), colormaps[NUMBERS]
    if len(steps) <= len(WORDS):
        shades = {one: colours(BRIGHTEST * k / max(len(steps) - 1, 1)) for k, one in enumerate(steps)}
        return [shades[one] for one in numbers], [_mark(shade, f"{one:.4g}") for one, shade in shades.items()], None
    norm = (LogNorm if _wide(numbers) else Normalize)(steps[0], steps[-1])
    bar = ScalarMappable(norm, ListedColormap(colours(np.linspace(0.0, BRIGHTEST, 256))))
    return list(bar.to_rgba(numbers)), [], bar


def _ranks(values: pd.Series) -> np.ndarray:
    """Rank of each value, 0 to 1; words are ranked as they first occur, a single value has 0.5."""
    ranks = pd.Series(_places(values, 1.0)[0]).rank(method="dense").to_numpy() - 1.0
    return ranks / ranks.max() if ranks.max() > 0.0 else np.full(len(ranks), 0.5)


def _marks(table: pd.DataFrame, columns: list[str]) -> tuple[list[str], list[Line2D]]:
    """A marker for each row by the first of the columns that has few values, and handles of a legend for them."""
    for column in columns:
        words = [_word(value) for value in table[column]]
        known = dict(zip(dict.fromkeys(words), MARKS, strict=False))
        if 1 < len(set(words)) <= len(MARKS):
            name = f"{_parts(column)[0].split()[-1]} " if _is_number(table[column]) else ""
            handles = [_mark(REFERENCE, f"{name}{word}", mark) for word, mark in known.items()]
            return [known[word] for word in words], handles
    return [MARK] * len(table), []


def _mark(color, words: str, mark: str = MARK) -> Line2D:
    """A marker for a legend."""
    return Line2D([], [], marker=mark, linestyle="", color=color, label=words)


def _is_number(values: pd.Series) -> bool:
    numbers = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
    return bool(numbers and values.notna().all())


def _wide(values: np.ndarray) -> bool:
    some = set(values)
    return len(some) > 2 and min(some) > 0.0 and max(some) >= WIDE * min(some)


def _word(value) -> str:
    if pd.isna(value):
        return "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
