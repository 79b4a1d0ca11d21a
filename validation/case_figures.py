"""Figures of several runs side by side, one panel for each initial void ratio: counterparts of the paper's."""

from pathlib import Path

from taichi_silo.runs.result import Result
from taichi_silo.runs.snapshot import shown_displacements
from taichi_silo.show.figures import draw_all
from taichi_silo.show.figures.forces import (
    ANGLE,
    FORCES,
    angle,
    draw_curve,
    janssen_line,
    reference_angle,
    x_axis,
)
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
from taichi_silo.show.figures.void_ratio import (
    aspect,
    chosen_snapshots,
    color_bar,
    color_range,
    draw_field,
    field_of,
    limits_of,
    moment,
)
from taichi_silo.show.figures.wall_stress import STRESSES, draw_stress, fit_bold, has_profiles, legend
from taichi_silo.show.titles import sand_title


def plot_cases(folders: dict[str, Path], target: Path) -> list[Path]:
    """Draw several runs side by side, one panel for each initial void ratio, and return the paths written.

    Parameters
    ----------
    folders : dict
        The runs' folders by the name that the legends show, such as "dense, smooth walls".
    target : Path
        Folder of the figures.
    """
    runs = [Result(folder, label, tolerant=True) for label, folder in folders.items()]
    return draw_all(CASE_FIGURES, runs, Path(target))


def by_void_ratio(runs: list[Result]) -> list[list[Result]]:
    """The runs in groups of equal initial void ratio, densest first."""
    groups = {}
    for run in runs:
        groups.setdefault(round(run.scene.sand.void_ratio, 3), []).append(run)
    return [groups[void_ratio] for void_ratio in sorted(groups)]


def case_forces_figure(runs):
    """Return the figure of P, T and N of several runs, one column for each initial void ratio."""
    groups = _drawable(runs)
    if not groups:
        return None
    figure = new_figure(1.2 + 5.4 * len(groups), 11.5)
    panels = figure.subplots(3, len(groups), squeeze=False, sharex="col", sharey="row")
    for column, group in enumerate(groups):
        for row, (name, label) in enumerate(FORCES.items()):
            panel = panels[row, column]
            for run, color in zip(group, line_colors(group), strict=True):
                draw_curve(panel, run, lambda rows, name=name: rows[name] / 1e3, color, run.label)
                if run.scene.walls.kind != "very-rough":
                    janssen_line(panel, run, name)
            if column == 0:
                panel.set_ylabel(label)
        panels[0, column].set_title(_group_title(column, group))
        _legend_under(panels[2, column])
        x_axis(panels[2, column], group)
    for row in panels:
        start_at_zero(row, "y")
    figure.suptitle("Forces per metre run\nT, N: mean of both walls; marker: end of filling")
    return figure


def case_angles_figure(runs):
    """Return the figure of the wall friction angle of several runs, one panel for each initial void ratio."""
    groups = _drawable(runs)
    if not groups:
        return None
    figure = new_figure(1.2 + 5.4 * len(groups), 5.4)
    panels = figure.subplots(1, len(groups), squeeze=False, sharey=True)[0]
    for column, (panel, group) in enumerate(zip(panels, groups, strict=True)):
        for run, color in zip(group, line_colors(group), strict=True):
            draw_curve(panel, run, angle, color, run.label)
            reference_angle(panel, run)
        if column == 0:
            panel.set_ylabel(ANGLE)
        panel.set_title(_group_title(column, group))
        _legend_under(panel)
        x_axis(panel, group)
    start_at_zero(panels, "y")
    figure.suptitle("Mobilised wall friction (marker: end of filling)")
    return figure


def case_void_ratio_figure(runs):
    """Return the figure of several runs, a row each; equal initial void ratios share a colour range."""
    cases = {id(run): chosen_snapshots(run) for run in runs}
    groups = by_void_ratio([run for run in runs if any(row is not None for row in cases[id(run)])])
    if not groups:
        return None
    fields = {
        id(run): [None if row is None else field_of(run, row["file"]) for row in cases[id(run)]]
        for group in groups
        for run in group
    }
    limits = limits_of([field for row in fields.values() for field in row if field is not None])
    columns, rows = max(map(len, fields.values())), sum(map(len, groups))
    height = 3.6
    width = 2.2 + columns * (0.3 + max(height * aspect(limits), 1.2))
    figure = new_figure(width, (height + 0.5) * rows + 0.6 * len(groups) + 0.3)
    parts = figure.subfigures(len(groups), 1, height_ratios=[len(group) for group in groups], squeeze=False)
    for part, group in zip(parts[:, 0], groups, strict=True):
        norm = color_range([field for run in group for field in fields[id(run)] if field is not None])
        panels = part.subplots(len(group), columns, squeeze=False, sharex=True, sharey=True)
        for run, line in zip(group, panels, strict=True):
            targets = [0.0, *shown_displacements(run.scene.flow)]
            for panel, row, field, target in zip(line, cases[id(run)], fields[id(run)], targets, strict=True):
                if field is None:
                    panel.set_axis_off()
                    missing = f"u = {1e3 * target:g} mm\nnot reached"
                    panel.text(0.5, 0.5, missing, ha="center", transform=panel.transAxes)
                    continue
                draw_field(panel, field, norm, limits, run.scene.silo)
                panel.set_title(moment(row, run.flow.empty))
            line[0].set_ylabel(f"{run.label}\nheight (mm)")
        for panel in panels[-1]:
            panel.set_xlabel("x (mm)")
        color_bar(part, panels.ravel().tolist(), norm)
    figure.suptitle("Void ratio at bottom displacement u")
    return figure


def case_wall_stress_figure(runs):
    """Return the figure of several runs, a column each: normal stresses above, shear stresses below."""
    runs = [run for run in runs if has_profiles(run)]
    if not runs:
        return None
    figure = new_figure(1.2 + 3.6 * len(runs), 11.0)
    panels = figure.subplots(2, len(runs), squeeze=False, sharex="row", sharey=True)
    for column, run in enumerate(runs):
        for row, quantity in enumerate(STRESSES):
            draw_stress(panels[row, column], run, quantity, name_origin=False)
            panels[row, column].set_xlabel(STRESSES[quantity])
        panels[0, column].set_title(f"{chr(97 + column)}) {run.label}")
    for row in panels:
        row[0].set_ylabel("height (mm)")
        start_at_zero(row, "x")
        fit_bold(row)
    handles = {}
    for panel in panels[0]:
        lines, labels = panel.get_legend_handles_labels()
        handles.update(zip(labels, lines, strict=True))
    columns = 5 if len(runs) > 3 else min(2, len(runs))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns)
    figure.suptitle(f"Wall stresses\n{legend(next((run for run in runs if run.lopsided), runs[0]))}")
    return figure


def _drawable(runs):
    return by_void_ratio([run for run in runs if not run.forces.empty])


def _group_title(column: int, group) -> str:
    return f"{chr(65 + column)}) {sand_title(group[0].scene.sand)}"


def _legend_under(panel):
    """Put a panel's legend below its x axis."""
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2)


def line_colors(runs) -> list[str]:
    """Return a colour for each run: blue for smooth walls, vermillion for very rough ones, then any other."""
    colors = []
    for run in runs:
        wanted = {"smooth": BLUE, "very-rough": VERMILLION}[run.scene.walls.kind]
        order = (wanted, GREEN, PURPLE, ORANGE, SKY, BLACK, BLUE, VERMILLION)
        colors.append(next((color for color in order if color not in colors), BLACK))
    return colors


CASE_FIGURES = {
    "forces": case_forces_figure,
    "wall_friction_angle": case_angles_figure,
    "void_ratio": case_void_ratio_figure,
    "wall_stress": case_wall_stress_figure,
}
