"""Void ratio in the silo at chosen bottom displacements, as filled squares (Fig. 12 of the paper)."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from taichi_silo.runs.result import Result
from taichi_silo.runs.snapshot import figured, shown_displacements
from taichi_silo.scene.closed_parts import closed_parts
from taichi_silo.show.figures.style import new_figure, put_title
from taichi_silo.show.report.words import length_unit, mm
from taichi_silo.show.titles import title

OVERLAP = 1.15  # squares are drawn larger by this factor, so that stretched sand shows no gaps
COLORS, STEEL = "viridis", "#404040"
WIDEST_IN = 40.0  # of a figure: 6,000 pixels
TWO_TICKS_IN, THREE_TICKS_IN = 0.35, 0.9  # length of an axis from which on so many labels have room
PANEL_IN, DEEPEST_IN = 13.0, 3.0  # largest width and height of the silo where the panels are one below the other
BAR_IN = 0.16  # width of the colour bar
CORNERS = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
EDGE = 0.004  # of the height, free around a large silo


def chosen_snapshots(run: Result) -> list:
    """The snapshot (a row of the index) at rest and those nearest to `shown_displacements` of the scene, each or None.

    A run that ended early shows its last state in place of the first displacement that it did not reach.
    """
    index, wanted = figured(run.snapshots), shown_displacements(run.scene.flow)
    if index.empty:
        return [None] * (1 + len(wanted))
    flow = index[index["stage"] == "flow"]
    if run.free:  # by what has left
        some = [*index[index["stage"] != "flow"].tail(1).iterrows(), *flow.head(len(wanted)).iterrows()]
        rows = [row for _, row in some]
        return rows + [None] * (1 + len(wanted) - len(rows))
    at_rest = index[index["displacement_m"] == index["displacement_m"].min()]
    chosen = [at_rest.iloc[-1]]
    ended = flow.empty
    for target in wanted:
        if ended:
            chosen.append(None)
            continue
        ended = flow["displacement_m"].iloc[-1] < 0.95 * target
        row = flow.iloc[-1] if ended else flow.loc[(flow["displacement_m"] - target).abs().idxmin()]
        known = [one["file"] for one in chosen if one is not None]
        chosen.append(None if row["file"] in known else row)
    return chosen


def field_of(run: Result, file: str):
    """Places (n, 2) [m] of a stored state, void ratio (n,), and side (n,) [m] of the square each point stands for."""
    points = run.state(file.removesuffix(".vtu"))
    place, void_ratio, volume = points["position"], points["void_ratio"], points["volume"]
    finite = np.isfinite(place).all(axis=1) & np.isfinite(void_ratio) & (volume > 0.0)
    return place[finite], void_ratio[finite], np.sqrt(volume[finite])


def run_void_ratio_figure(run: Result) -> Figure | None:
    """Figure of one run, or None without snapshots."""
    rows = [row for row in chosen_snapshots(run) if row is not None]
    if not rows:
        return None
    fields = [field_of(run, row["file"]) for row in rows]
    if not any(len(void_ratio) for _, void_ratio, _ in fields):
        return None
    unit, per_m = length_unit(max(run.scene.silo.height_m, run.scene.silo.width_m))
    silo = run.scene.silo
    norm, limits = color_range(fields), around(silo, limits_of(fields, per_m), per_m)
    height = 4.8
    few = len(rows) < 3
    width = 1.3 + len(rows) * (0.42 + max(height * aspect(limits), 1.2))
    stacked = width > WIDEST_IN  # of wide silos one below the other
    if stacked:
        deep = min(PANEL_IN / aspect(limits), DEEPEST_IN)
        figure = new_figure(deep * aspect(limits) + 2.6, 1.5 + len(rows) * (deep + 0.75))
        panels = figure.subplots(len(rows), 1, squeeze=False, sharex=True)[:, 0]
    else:
        figure = new_figure(max(width, 4.6), height + (1.9 if few else 1.35))
        panels = figure.subplots(1, len(rows), squeeze=False, sharey=True)[0]
    for panel, row, field in zip(panels, rows, fields, strict=True):
        draw_field(panel, field, norm, limits, silo, per_m)
        panel.set(xlabel=f"x ({unit})", title=moment(row, run.flow.empty))
        if stacked:
            top = round(per_m * run.scene.silo.height_m, 2)
            panel.set_yticks([0.0, top] if deep > TWO_TICKS_IN else [top])
            panel.label_outer()
        elif height * aspect(limits) < THREE_TICKS_IN:
            low, *_, high = _ticks(silo, limits[0], per_m)
            panel.set_xticks([low, high] if height * aspect(limits) > TWO_TICKS_IN else [high])
    if stacked:
        figure.supylabel(f"height ({unit})", fontsize=12)
    else:
        panels[0].set_ylabel(f"height ({unit})")
    color_bar(figure, panels, norm)
    short = few and not stacked
    put_title(figure, *(f"Void ratio: {title(run)}".split(", ") if short else [f"Void ratio: {title(run)}"]))
    return figure


def around(silo, limits, per_m: float = 1e3):
    """Such limits, widened to both walls where these are drawn."""
    (left, right), along = limits
    return limits if silo.floor_is_outlet else ((min(left, 0.0), max(right, per_m * silo.width_m)), along)


def draw_field(panel, field, norm, limits, silo, per_m: float = 1e3):
    """Draw one square for each point, and what stands in the silo, the closed parts of its floor and walls."""
    position, void_ratio, side = field
    squares = per_m * (position[:, None, :] + OVERLAP * side[:, None, None] * CORNERS)
    squares[..., 0] = np.clip(squares[..., 0], *limits[0])  # the overlap must not reach over the walls
    cells = PolyCollection(squares, array=void_ratio, cmap=COLORS, norm=norm, antialiased=False, linewidth=0)
    panel.add_collection(cells)
    for outline in silo.solids():
        panel.add_patch(Polygon(per_m * outline, facecolor=STEEL, linewidth=0, zorder=2))
    panel.set(xlim=limits[0], ylim=limits[1], aspect="equal", xticks=_ticks(silo, limits[0], per_m))
    panel.grid(False)
    panel.spines["right"].set_visible(silo.floor_is_outlet)
    panel.spines["bottom"].set_visible(False)
    if not silo.floor_is_outlet:
        _draw_walls(panel, limits, silo, per_m)


def _draw_walls(panel, limits, silo, per_m: float) -> None:
    """Draw the closed parts of floor and side walls as lines."""
    look = {"color": STEEL, "linewidth": 2.0, "zorder": 3, "clip_on": False, "solid_capstyle": "butt"}
    for part in closed_parts(silo, "floor"):
        panel.plot(per_m * np.array(part), (0.0, 0.0), **look)
    for wall, x, foot in zip(("left", "right"), (0.0, silo.width_m), silo.feet_m, strict=True):
        for part in closed_parts(silo, wall):
            panel.plot([per_m * x] * 2, np.clip(per_m * np.array(part), per_m * foot, limits[1][1]), **look)
    panel.set(xlim=limits[0], ylim=limits[1])


def _ticks(silo, limits, per_m: float):
    """Ticks at both walls and half-way, to 10 mm where there is room for it, of narrow ones and in m as they are."""
    limits = limits if silo.floor_is_outlet else (0.0, per_m * silo.width_m)
    wide = limits[1] - limits[0]
    low, high = np.round(limits, -1 if wide > 50.0 else 0 if wide > 5.0 else 2) + 0.0
    return [low, (low + high) / 2.0, high]


def moment(row, still_filling: bool) -> str:
    """When a snapshot was taken."""
    if still_filling:
        return f"filling, t = {row['time_s']:.3g} s"
    return f"u = {mm(row['displacement_m'], 3)}"


def color_range(fields) -> Normalize:
    """A colour range from the 0.5 to the 99.5 percentile of all fields."""
    low, high = np.nanpercentile(np.concatenate([field[1] for field in fields]), (0.5, 99.5))
    if high - low < 0.01:  # a uniform field shall look uniform
        low, high = 0.5 * (low + high) - 0.005, 0.5 * (low + high) + 0.005
    return Normalize(low, high)


def limits_of(fields, per_m: float = 1e3):
    """Ends (low, high) of x and of height around all fields, in units of which so many make a metre: mm, or m."""
    fields = [field for field in fields if len(field[1])]  # an empty silo has no ends
    low = np.min([np.min(position - 0.5 * side[:, None], axis=0) for position, _, side in fields], axis=0)
    high = np.max([np.max(position + 0.5 * side[:, None], axis=0) for position, _, side in fields], axis=0)
    rim = 2.0 if per_m > 1.0 else EDGE * (high[1] - low[1])
    return (per_m * low[0], per_m * high[0]), (per_m * low[1] - rim, per_m * high[1] + rim)


def aspect(limits) -> float:
    """Width over height of such limits."""
    return (limits[0][1] - limits[0][0]) / (limits[1][1] - limits[1][0])


def color_bar(figure, panels, norm):
    """Put the scale of the void ratio beside the panels of a figure, or of a part of one."""
    scale = ScalarMappable(norm, COLORS)
    aspect = max(30.0, 0.8 * figure.bbox.height / figure.dpi / BAR_IN)
    figure.colorbar(
        scale, ax=panels, label="void ratio e", extend="both", shrink=0.8, aspect=aspect, extendfrac=1.5 / aspect,
        pad=0.02,
    )  # fmt: skip
