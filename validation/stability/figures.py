"""Figures of the stability map, and the page that holds them."""

import html
import math
import textwrap
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from taichi_silo.show.figures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, REFERENCE, SKY, VERMILLION, new_figure

HOLDS, BREAKS = "#BFE5D6", "#F3C9AE"  # light green and vermillion; the sign in the cell says the same
COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)


def number(value: float) -> str:
    """Three digits."""
    if math.isinf(value):
        return "lost"
    return f"{value:.3g}" if value == 0 or 1e-3 <= abs(value) < 1e4 else f"{value:.1e}"


def matrix(rows: pd.DataFrame, title: str) -> Figure:
    """Measures by methods: the measured number, green with a tick where it holds, red with a cross where it breaks."""
    measures = list(dict.fromkeys(zip(rows.measure, rows.bound, strict=True)))
    methods = list(dict.fromkeys(rows.method))
    figure = new_figure(max(8.0, 4.6 + 1.25 * len(methods)), 1.1 + 0.36 * len(measures) + 0.5)
    axes = figure.subplots()
    table = {(r.measure, r.bound, r.method): r for r in rows.itertuples()}
    for j, (measure, bound) in enumerate(measures):
        for i, method in enumerate(methods):
            cell = table.get((measure, bound, method))
            if cell is None:
                continue
            color = HOLDS if cell.holds else BREAKS
            axes.fill([i - 0.48, i + 0.48, i + 0.48, i - 0.48], [j - 0.45, j - 0.45, j + 0.45, j + 0.45], color=color)
            sign = "\u2713" if cell.holds else "\u2717"
            axes.text(i, j, f"{number(cell.value)} {sign}", ha="center", va="center", fontsize=8.5)
    axes.set_yticks(range(len(measures)), [f"{m}   {b}" for m, b in measures], fontsize=8.5)
    axes.set_xticks(range(len(methods)), [textwrap.fill(m, 15) for m in methods], fontsize=8.5)
    axes.set(xlim=(-0.5, len(methods) - 0.5), ylim=(len(measures) - 0.5, -0.5))
    axes.tick_params(length=0, labeltop=True, labelbottom=False)
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.set_title(title, loc="left", fontsize=12, pad=10)
    return figure


def order_figure(data: dict) -> Figure:
    """Errors of the manufactured solutions against the number of cells."""
    figure = new_figure(12.0, 4.6)
    panels = figure.subplots(1, len(data), sharey=True)
    for panel, (solution, methods) in zip(panels, data.items(), strict=True):
        for k, (name, errors) in enumerate(methods.items()):
            cells = sorted(map(int, errors))
            values = [errors.get(n, errors.get(str(n))) for n in cells]
            style = "-" if k < 5 else ":"
            color = COLORS[k % len(COLORS)]
            panel.loglog(cells, values, style + "o", color=color, label=name, linewidth=1.5, markersize=4)
        n = [cells[0], cells[-1]]
        panel.loglog(n, [0.05, 0.05 * n[0] / n[1]], "--", color=REFERENCE, linewidth=1)
        panel.loglog(n, [0.05, 0.05 * (n[0] / n[1]) ** 2], "--", color=REFERENCE, linewidth=1)
        panel.set(xlabel="cells over the unit length", title=solution)
        panel.set_xticks(cells, [str(c) for c in cells], minor=False)
        panel.minorticks_off()
    lines = {line.get_label(): line for line in panels[1].lines if not line.get_label().startswith("_")}
    figure.legend(lines.values(), lines.keys(), loc="outside right upper", fontsize=8.5)
    panels[0].set_ylabel("RMS error over the motion\n(dashed: first and second order)")
    return figure


def ratcheting_figure(data: dict) -> Figure:
    """N in flow over Janssen's, against time."""
    figure = new_figure(11.0, 5.0)
    axes = figure.subplots()
    for k, (name, history) in enumerate(data.items()):
        time = [t - history["time"][0] for t in history["time"]]
        ratio = [n / history["janssen"] for n in history["normal"]]
        style = ("-", "--", ":")[k // len(COLORS) % 3]
        axes.plot(time, ratio, style, color=COLORS[k % len(COLORS)], linewidth=1.3, label=name)
    axes.axhline(1.0, color=REFERENCE, linestyle=":", linewidth=1.2, label="Janssen, K0 of the sand")
    axes.set(xlabel="time since the bottom starts to sink at 5 mm/s (s)", ylabel="N / N of Janssen (-)")
    axes.set_ylim(0.6, 1.6)
    axes.set_title("Dense sand between smooth walls, 10 mm cells: noise and what is done about it", loc="left")
    axes.legend(fontsize=8.5, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def page(rows: pd.DataFrame, figures: list[Path], folder: Path) -> str:
    """An HTML page: what holds and what breaks, then every figure (file names relative to `folder`)."""
    holds, total = int(rows.holds.sum()), len(rows)
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Stability map</title>",
        "<meta name='viewport' content='width=device-width'>",
        "<style>body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:75rem;padding:0 1rem}",
        "img{max-width:100%;height:auto}</style></head><body><h1>Stability map</h1>",
        f"<p>{total} numbers in <a href='table.csv'>table.csv</a>: {holds} hold, {total - holds} break.</p>",
    ]
    for file in figures:
        name = html.escape(str(file.relative_to(folder)))
        parts.append(f"<p><img src='{name}' alt='{html.escape(file.stem)}'></p>")
    return "\n".join([*parts, "</body></html>", ""])
