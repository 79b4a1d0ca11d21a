"""Forces of many runs over the bottom displacement: few of them coloured, so that each can be told from the others."""

import numpy as np
from matplotlib.figure import Figure

from taichi_silo.runs.result import Result, residual
from taichi_silo.show.figures.forces import FORCES, displacement_unit, running_median, x_axis
from taichi_silo.show.figures.style import COLORS, new_figure, start_at_zero
from taichi_silo.utils.messages import counted

OTHERS = "#B0B0B0"


def batch_figure(runs: list[Result]) -> Figure | None:
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
            x = displacement_unit(runs)[1] * run.flow["displacement_m"]
            coloured = run.label in chosen
            panel.plot(
                x, running_median(x, run.flow[name] / 1e3), color=chosen.get(run.label, OTHERS),
                linewidth=1.8 if coloured else 0.8, label=run.label if coloured else None,
            )  # fmt: skip
        panel.set_ylabel(label)
        x_axis(panel, runs)
        start_at_zero([panel], "y")
    handles = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
    figure.legend([handles[name] for name in chosen], chosen, loc="outside lower center", ncols=1)
    others = f"; grey: {len(runs) - len(chosen)} others" if len(runs) > len(chosen) else ""
    figure.suptitle(
        f"Forces per metre run of {counted(len(runs), 'run')}\nT, N: mean of both walls; running median{others}"
    )
    return figure


def _spread(runs: list[Result]) -> list[Result]:
    """All runs, or as many as there are colours, evenly from the least to the largest residual N."""
    if len(runs) <= len(COLORS):
        return runs
    ordered = sorted(runs, key=lambda run: residual(run.flow)["N"].mean())
    return [ordered[k] for k in np.linspace(0, len(ordered) - 1, len(COLORS)).round().astype(int)]
