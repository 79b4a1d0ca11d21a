"""Normal and shear stress along the walls against height (Fig. 13 of the paper)."""

import numpy as np
from matplotlib.figure import Figure

from taichi_silo.analysis.measure.wall_pressure import cell_mean
from taichi_silo.runs.inclined_walls import none_vertical
from taichi_silo.runs.result import Result
from taichi_silo.show import theory
from taichi_silo.show.figures.style import (
    BLACK,
    BLUE,
    REFERENCE,
    VERMILLION,
    legend_below,
    new_figure,
    put_title,
    start_at_zero,
)
from taichi_silo.show.report.states import reading_of
from taichi_silo.show.report.words import length_unit, mm
from taichi_silo.show.titles import title

STATES = {  # colour, width (equal curves on top of each other both show), name
    "filling": (BLACK, 2.0, "after filling"),
    "maximum": (VERMILLION, 3.4, "maximum (N largest)"),
    "residual": (BLUE, 1.8, "residual"),
}
BOLD = min(width for _, width, _ in STATES.values())
STRESSES = {"normal_stress_Pa": "wall normal stress (kPa)", "shear_stress_Pa": "wall shear stress (kPa)"}


def run_wall_stress_figure(run: Result) -> Figure | None:
    """Figure of one run, or None without wall profiles."""
    if not has_profiles(run):
        return None
    figure = new_figure(9.6, 6.4)
    panels = figure.subplots(1, 2, sharey=True)
    for panel, quantity in zip(panels, STRESSES, strict=True):
        draw_stress(panel, run, quantity)
        panel.set_xlabel(STRESSES[quantity])
        start_at_zero([panel], "x")
        fit_bold([panel])
    panels[0].set_ylabel(f"height above the initial bottom ({length_unit(run.scene.silo.height_m)[0]})")
    handles, labels = panels[0].get_legend_handles_labels()
    legend_below(figure, handles, labels, 2)
    put_title(figure, f"Wall stresses: {title(run)}", legend(run))
    return figure


def legend(run: Result) -> str:
    """What the lines of a run's figure are."""
    reading, silo = reading_of(run), run.scene.silo
    whose = "" if run.lopsided else "mean of both walls, "
    inclined = f"inclined walls over {mm(reading.hopper_cell_m)} of height"
    cells = [f"as a pressure cell of {mm(reading.cell_m)} reads"]
    if none_vertical(silo):
        whose, cells = whose.replace("walls, ", ""), [inclined]
    elif any(silo.feet_m):
        cells.append(f"below {mm(silo.transition_m)} {inclined}")
    if run.lopsided:
        return f"bold: {whose}{', '.join(cells)}; walls not alike: left solid, right dashed"
    light = "" if none_vertical(silo) else "; light: each vertical wall, node by node"
    return f"bold: {whose}{', '.join(cells)}{light}"


def fit_bold(panels):
    """Let the bold curves and the theories fill the axis: single nodes in a corner may stick out."""
    lines = [line for panel in panels for line in panel.get_lines()]
    bold = [line.get_xdata() for line in lines if line.get_linewidth() >= BOLD]
    theories = [line.get_xdata() for line in lines if line.get_color() == REFERENCE]
    largest, beyond = (np.nanmax(np.concatenate([[0.0], *found])) for found in (bold, theories))
    if largest > 0.0:
        panels[0].set_xlim(right=max(1.35 * largest, 1.05 * beyond))


def has_profiles(run: Result) -> bool:
    """Whether a run has stresses of its vertical walls."""
    return bool(run.walls["wall"].isin(["left", "right"]).any())


def draw_stress(panel, run: Result, quantity: str, name_origin: bool = True, per_m: float | None = None):
    """Draw one stress [kPa] against height, in units of which so many make a metre, with Janssen's theory."""
    per_m = length_unit(run.scene.silo.height_m)[1] if per_m is None else per_m
    reading = reading_of(run)
    lines = ("-", (0, (2, 1)) if run.lopsided else "-")
    vertical = () if none_vertical(run.scene.silo) else ("left", "right")  # which stand above the sand
    inclined = ("hopper_left", "hopper_right")
    for state, (color, width, label) in STATES.items():
        for height, stress in _profiles(run, state, quantity, vertical):
            panel.plot(stress / 1e3, per_m * height, color=color, alpha=0.35, linewidth=0.9)
        named: str | None = label
        for walls, cell_m in ((vertical, reading.cell_m), (inclined, reading.hopper_cell_m)):
            profiles = _profiles(run, state, quantity, walls)
            if profiles and not run.lopsided:
                height = profiles[0][0]
                profiles = [(height, np.mean([np.interp(height, *profile) for profile in profiles], axis=0))]
            for (height, stress), line in zip(profiles, lines, strict=False):
                read = cell_mean(height, stress, cell_m) / 1e3
                panel.plot(read, per_m * height, color=color, linewidth=width, linestyle=line, label=named, zorder=3)
                named = None
    _draw_janssen(panel, run, quantity, name_origin, per_m)
    _draw_code(panel, run, quantity, per_m)
    panel.set_ylim(top=1.05 * per_m * run.scene.silo.height_m)  # nodes above the sand carry nothing


def _profiles(run: Result, state: str, quantity: str, walls: tuple[str, ...]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Heights [m] and stresses [Pa] of those of some walls that have any."""
    profiles = [run.profile(state, wall, quantity) for wall in walls]
    return [profile for profile in profiles if len(profile[0])]


def _draw_janssen(panel, run: Result, quantity: str, name_origin: bool, per_m: float):
    """Draw Janssen's stress for each stored pressure ratio."""
    for (origin, ratio), line in zip(theory.pressure_ratios(run).items(), ("--", ":"), strict=False):
        fill = theory.janssen(run, ratio)
        if fill is None:
            return
        height = np.linspace(0.0, fill.height_m, 101)
        stress = fill.normal_stress_Pa if quantity == "normal_stress_Pa" else fill.shear_stress_Pa
        label = f"Janssen, {origin}"
        if name_origin:
            label += f" = {ratio:.2f}, $\\varphi_w$ = {fill.wall_friction_angle_deg:.3g}°"
        place = per_m * (run.scene.silo.transition_m + height)
        panel.plot(
            stress(fill.height_m - height) / 1e3, place, color=REFERENCE, linestyle=line, zorder=3.5, label=label
        )


def _draw_code(panel, run: Result, quantity: str, per_m: float):
    """Draw the stress on discharge after EN 1991-4, of the solid that the scene names."""
    code = theory.eurocode(run)
    if code is None:
        return
    height, foot = np.linspace(0.0, code.height_m, 101), run.scene.silo.transition_m
    law = code.discharge_normal_Pa if quantity == "normal_stress_Pa" else code.discharge_shear_Pa
    stress = np.asarray(law(code.height_m - height))
    if not stress.max(initial=0.0) > 0.0:  # of a flat silo the code's surface lies below the floor at the wall
        return
    panel.plot(
        stress / 1e3, per_m * (foot + height), color=REFERENCE, linestyle="-.",
        linewidth=1.0, zorder=3.4, label=f"EN 1991-4, discharge, its {code.solid.title}",
    )  # fmt: skip
