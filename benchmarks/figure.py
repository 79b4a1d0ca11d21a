"""The picture of the benchmark: cost of the phases, share of the yardstick, and the roof above the phases."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import rc_context

from benchmarks.roofline import BYTES, FLOPS, NODE_BYTES
from taichi_silo.show.figures.style import BLUE, REFERENCE, SKY, STYLE, VERMILLION, new_figure

PHASES = ("particles to grid", "grid", "grid to particles", "law")  # the last: what it adds to the third
COLORS = (BLUE, REFERENCE, SKY, VERMILLION)


def draw(table: pd.DataFrame, roof: dict[str, float], file: Path) -> None:
    """Draw and save the picture of a table, below the roof of this machine (`roofline.ceilings`)."""
    with rc_context(STYLE):
        figure = new_figure(13.0, 4.4)
        costs, ratios, roofline = figure.subplots(1, 3)
        _phases(costs, table)
        _ratios(ratios, table)
        _roofline(roofline, table, roof)
        figure.savefig(file, dpi=150)


def _phases(axes, table: pd.DataFrame) -> None:
    """Cost of each phase, stacked, for each size."""
    alone = table[(table.threads == 1) & table.phase.isin((*PHASES, "grid to particles, law"))]
    sizes = list(dict.fromkeys(zip(alone.points, alone.points_per_cell, strict=True)))
    bottom = np.zeros(len(sizes))
    for phase, color in zip(PHASES, COLORS, strict=True):
        height = [_cost(alone[(alone.points == n) & (alone.points_per_cell == c)], phase) for n, c in sizes]
        axes.bar(range(len(sizes)), height, bottom=bottom, color=color, label=phase)
        bottom += np.nan_to_num(height)
    axes.set_xticks(range(len(sizes)), [f"{n / 1e3:.0f}k\n{c}" for n, c in sizes])
    axes.set(
        xlabel="points, and points a cell", ylabel="ns a point and step, one thread", title="Phases of the step",
        ylim=(0.0, 1.5 * bottom.max()),
    )  # fmt: skip
    axes.legend(frameon=False, fontsize="small", loc="upper left", ncols=2)


def _cost(rows: pd.DataFrame, phase: str) -> float:
    """Cost of a phase [ns a point and step]; of the law what it adds to the way from the grid."""

    def of(name: str) -> float:
        return rows[rows.phase == name].nanoseconds_per_particle_step.mean()

    return of("grid to particles, law") - of("grid to particles") if phase == "law" else of(phase)


def _ratios(axes, table: pd.DataFrame) -> None:
    """Speed of the step over that of the yardstick."""
    steps = table[(table.phase == "step") & table.yardstick_ratio.notna()]
    for (per_cell, threads), some in steps.groupby(["points_per_cell", "threads"]):
        axes.plot(
            some.points, some.yardstick_ratio, marker="os"[threads > 1], color=COLORS[0 if per_cell == 1 else 3],
            linestyle="-" if threads == 1 else "--", label=f"{per_cell} a cell, {threads} thread{'s'[: threads - 1]}",
        )  # fmt: skip
    axes.axhline(0.8, color="0.6", linewidth=0.8)
    axes.set(xscale="log", xlabel="points", ylabel="speed over the yardstick's", title="Beside C++", ylim=(0.0, None))
    sizes = sorted({round(points, -3) for points in steps.points})
    axes.set_xticks(sizes, [f"{points / 1e3:.0f}k" for points in sizes])
    axes.minorticks_off()
    if not steps.empty:
        axes.legend(frameon=False, fontsize="small")


def _roofline(axes, table: pd.DataFrame, roof: dict[str, float]) -> None:
    """Operations a second against operations a byte, below the limits of one core."""
    intensity = np.logspace(-1.5, 2, 100)
    for name, style in (("cache", "--"), ("memory", "-")):
        axes.plot(intensity, np.minimum(roof["arithmetic"], roof[name] * intensity) / 1e9, color="0.3", linestyle=style,
                  label=f"{name}: {roof[name] / 1e9:.0f} GB/s")  # fmt: skip
    for (_points, per_cell), rows in table[table.threads == 1].groupby(["points", "points_per_cell"]):
        for phase, color in zip(PHASES, COLORS, strict=True):
            if phase in FLOPS:
                moved = BYTES[phase] + NODE_BYTES.get(phase, 0) / per_cell
                axes.plot(FLOPS[phase] / moved, FLOPS[phase] / _cost(rows, phase), color=color,
                          marker="o" if per_cell == 1 else "s", linestyle="none")  # fmt: skip
    axes.set(
        xscale="log", yscale="log", xlabel="operations a byte", ylabel="10⁹ operations a second",
        title=f"Roof of one core: {roof['arithmetic'] / 1e9:.0f} · 10⁹/s",
    )  # fmt: skip
    axes.legend(frameon=False, fontsize="small")
