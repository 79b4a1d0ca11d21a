"""Forces of many runs over the bottom displacement: few of them coloured, so that each can be told from the others."""

from matplotlib.figure import Figure

from taichi_silo.show.figures.forces import FORCES, force, running_median, x_axis
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    new_figure,
    start_at_zero,
)

COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
OTHERS = "#B0B0B0"
RESIDUAL = 0.95  # of the displacement: where the residual state begins


def batch_figure(runs: list[RunFiles]) -> Figure | None:
    """Return P, T and N of all runs over the bottom displacement, or None if none has flowed.

    Up to seven runs have a colour each; of more, seven from the least to the largest residual N have one.
    """
    runs = [run for run in runs if not run.flow.empty]
    if not runs:
        return None
    chosen = {run.label: color for run, color in zip(_spread(runs), COLORS, strict=False)}
    figure = new_figure(13.5, 5.2 + 0.28 * len(chosen))
    panels = figure.subplots(1, 3)
    for (name, label), panel in zip(FORCES.items(), panels, strict=True):
        for run in sorted(runs, key=lambda run: run.label in chosen):
            x = 1e3 * run.flow["displacement_m"]
            coloured = run.label in chosen
            panel.plot(
                x, running_median(x, force(run.flow, name)), color=chosen.get(run.label, OTHERS),
                linewidth=1.8 if coloured else 0.8, label=run.label if coloured else None,
            )  # fmt: skip
        panel.set_ylabel(label)
        x_axis(panel, runs)
        start_at_zero([panel], "y")
    handles = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
    figure.legend([handles[name] for name in chosen], chosen, loc="outside lower center", ncols=1)
    others = f"; grey: {len(runs) - len(chosen)} others" if len(runs) > len(chosen) else ""
    figure.suptitle(f"Forces per metre run of {len(runs)} runs\nT, N: mean of both walls; running median{others}")
    return figure


def _spread(runs: list[RunFiles]) -> list[RunFiles]:
    """All runs, or as many as there are colours, evenly from the least to the largest residual N."""
    if len(runs) <= len(COLORS):
        return runs
    ordered = sorted(runs, key=_residual)
    last = len(COLORS) - 1
    return [ordered[round(k * (len(ordered) - 1) / last)] for k in range(len(COLORS))]


def _residual(run: RunFiles) -> float:
    late = run.flow["displacement_m"] >= RESIDUAL * run.flow["displacement_m"].max()
    return float(force(run.flow[late], "N").mean())
