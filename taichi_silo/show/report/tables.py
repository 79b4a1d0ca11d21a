"""The tables of a report: forces, wall stresses and shear zones of the run, beside what theory says."""

from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.measure.wall_pressure import cell_mean
from taichi_silo.analysis.theory.walker import WalkerHopper
from taichi_silo.runs.eurocode import whose_numbers
from taichi_silo.runs.inclined_walls import inclined_walls
from taichi_silo.runs.result import Result
from taichi_silo.runs.theories import hopper_of, janssen_of
from taichi_silo.show.beside_walls import beyond_janssen
from taichi_silo.show.report.states import FORCES, STATES, Force, forces_of, reading_of, wall_profile
from taichi_silo.show.report.words import NONE, height_words, kN, kPa, length_unit, mm, number, per_cent
from taichi_silo.show.theory import eurocode, janssen, pressure_ratios, straight_m

HEIGHTS = (0.9, 0.75, 0.5, 0.25, 0.1)  # of the vertical walls, from the foot
HOPPER_HEIGHTS = (0.9, 0.7, 0.5, 0.3, 0.1)  # of the hopper
TITLES = {
    "P": "bottom, P (kN/m)", "T": "wall friction, T (kN/m)", "N": "wall normal, N (kN/m)", "angle": "arctan(T/N) (°)",
}  # fmt: skip
ORIGINS = {"K0": "K₀ of the law", "measured": "K in the sand"}
WHEN = ("after filling", "in flow")
ON_WALL = {"T": "T along it", "N": "N across it"}
NAMES = {"K0 of the law": "K₀ of the law", "measured K": "K in the sand"}  # of `pressure_ratios`


@dataclass(frozen=True)
class ReportTable:
    """Head, rows of words, and a note below; the first column names the rows."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def force_table(run: Result) -> ReportTable:
    """Table of P, T, N and the wall friction angle in three states, and Janssen's theory after filling."""
    forces, theory = forces_of(run), run.summary.get("janssen") or {}
    origins = [key for key in ORIGINS if f"normal_N_per_m_{key}" in theory]
    head = ["force", "after filling", *(f"Janssen, {ORIGINS[key]}" for key in origins), "peak in flow", "end of flow"]
    rows: list[tuple[str, ...]] = []
    for name, title in TITLES.items():
        one = forces[name]
        if name != "P" and not straight_m(run):  # no vertical walls
            continue
        told = [_theory(one, theory, name, key) for key in origins]
        show = (lambda value: number(value)) if name == "angle" else kN
        peak = show(one.peak) if one.peak is None else f"{show(one.peak)} at u = {mm(one.peak_m, 3)}"
        rows.append((title, show(one.filled), *told, peak, show(one.residual)))
    for column in run.forces.columns:
        sideways = run.scene.silo.section == "plane" and column.endswith("_horizontal_N_per_m")  # round: none in sum
        if sideways or column.endswith("_vertical_N_per_m"):
            rows.append(_of_body(run, column, len(origins)))
    rows += [*_above_foot(theory, origins), *_inclined(run, len(origins))]
    return ReportTable(tuple(head), tuple(rows), _force_note(run, theory))


def _theory(one: Force, theory: dict, name: str, key: str) -> str:
    if name == "angle":
        return number(theory.get("wall_friction_angle_deg"))
    value = theory.get(f"{FORCES[name][0]}_{key}")
    if value is None:
        return NONE
    if theory.get("walls") and name != "P":  # each wall has a row of its own
        return NONE
    if not one.filled or not value:
        return kN(value)
    return f"{kN(value)} (run {per_cent(one.filled / value - 1.0, signed=True)})"


def _above_foot(theory: dict, origins: list[str]) -> list[tuple[str, ...]]:
    """N and T after filling of each wall above the higher foot, beside Janssen, where walls are not alike."""
    rows = []
    for wall, forces in (theory.get("walls") or {}).items():
        for name in ("T", "N"):
            key = FORCES[name][0]
            force = Force(filled=forces[key])
            told = [_theory(force, {one: value for one, value in theory.items() if one != "walls"}, name, origin)
                    for origin in origins]  # fmt: skip
            title = f"{wall} wall above {mm(theory['above_m'])}, {name} (kN/m)"
            rows.append((title, kN(forces[key]), *told, NONE, NONE))
    return rows


def _inclined(run: Result, gap: int) -> list[tuple[str, ...]]:
    """N and T after filling and at the end of the straight inclined walls."""
    states = [{} if rows is None else inclined_walls(run.scene.silo, rows) for rows in (run.filled, run.residual)]
    sides = [side for side in ("left", "right") if any(side in state for state in states)]
    rows = []
    for side in sides:
        words = "hopper" if run.scene.silo.section == "round" else f"hopper {side}"
        for name in ("T", "N"):
            filled, last = (kN(state[side][name]) if side in state else NONE for state in states)
            rows.append((f"{words}, {ON_WALL[name]} (kN/m)", filled, *[NONE] * gap, NONE, last))
    return rows


def _of_body(run: Result, column: str, gap: int) -> tuple[str, ...]:
    """A hopper wall's or an insert's force on the sand, to the right or upwards."""
    words = column.removesuffix("_N_per_m").replace("_", " ")
    words = words.replace("hopper right", "hopper") if run.scene.silo.section == "round" else words
    words = words.replace(" horizontal", ", to the right").replace(" vertical", ", upwards")
    filled = None if run.filled is None else run.filled.get(column)
    last = None if run.residual is None else run.residual.get(column)
    return (f"{words} (kN/m)", kN(filled), *[NONE] * gap, NONE, kN(last))


def _force_note(run: Result, theory: dict) -> str:
    words = "T and N are means of both walls; the peak of P is its least value."
    if not straight_m(run):
        words = "No walls are vertical, so there is no Janssen; the peak of P is its least value."
    if run.scene.silo.section == "round":
        words += " Forces of the round silo are per metre of girth; P and the weight count two such metres."
    ratios = [
        f"{ORIGINS[key]} = {number(theory[f'pressure_ratio_{key}'])}"
        for key in ORIGINS
        if theory.get(f"pressure_ratio_{key}") is not None
    ]
    if ratios and straight_m(run):
        angle = number(theory.get("wall_friction_angle_deg"))
        words += f" Janssen: wall friction {angle}°, {', '.join(ratios)} (in brackets: the run against it)."
        words += f" {beyond_janssen(run)}".rstrip()
    found = run.summary.get("theory") or {}
    walker = [found[f"walker_{state}"] for state in ("filling", "discharge") if found.get(f"walker_{state}")]
    if len(walker) == len(WHEN):
        wall, outlet = (
            " and ".join(f"{kN(one[f'{part}_force_N_per_m'])} {when}" for when, one in zip(WHEN, walker, strict=True))
            for part in ("wall", "outlet")
        )
        who = "the wall carries" if run.scene.silo.section == "round" else "each wall carries"
        words += f" Walker's theory of the hopper (kN/m): {who} {wall} upwards, the outlet {outlet}."
    return words


def stress_table(run: Result) -> ReportTable | None:
    """Table of wall normal stresses at some heights, with Janssen and EN 1991-4; None without wall profiles."""
    sides, silo = ("left", "right") if run.lopsided else ("both",), run.scene.silo
    if not straight_m(run) or not len(wall_profile(run, "filling", wall=sides[0])[0]):
        return None
    heights = [silo.transition_m + share * straight_m(run) for share in HEIGHTS]
    laws = {origin: janssen(run, ratio) for origin, ratio in pressure_ratios(run).items()}
    theories = {f"Janssen, {NAMES.get(origin, origin)}": law for origin, law in laws.items() if law is not None}
    code = eurocode(run)
    unit, per_m = length_unit(silo.height_m)
    head = [f"height ({unit})", "after filling", *theories, *(["EN 1991-4, filling"] if code else [])]
    head += ["in flow, N largest", "end of flow", *(["EN 1991-4, discharge"] if code else [])]
    rows = []
    for height in heights:
        depth = silo.height_m - height
        filling, maximum, residual = (_read(run, state, sides, height) for state in STATES)
        row = [
            height_words(height, per_m),
            filling,
            *(kPa(float(law.normal_stress_Pa(depth))) for law in theories.values()),
        ]
        row += [kPa(float(code.filling_normal_Pa(depth)))] if code else []
        row += [maximum, residual]
        row += [kPa(float(code.discharge_normal_Pa(depth)))] if code else []
        rows.append(tuple(row))
    where = "left / right wall" if run.lopsided else "mean of both walls"
    cell = mm(reading_of(run).cell_m)
    note = (
        f"Wall normal stress in kPa, as a pressure cell of {cell} reads it, {where}; height above the initial bottom."
    )
    if code:
        values = code.values("wall pressure")
        note += (
            f" EN 1991-4: {code.slenderness} silo, its solid {code.solid.title} on a {code.wall} wall, characteristic "
            f"values without patch loads. Filling: γ = {code.solid.upper_weight_density_N_per_m3 / 1e3:g} kN/m³, K = "
            f"{values.pressure_ratio:.3g}, μ = {values.wall_friction:.3g}; discharge: C_h = "
            f"{code.discharge_factors[0]:.3g} times that. {whose_numbers(run.scene)}"
        )
        limits = ((run.summary.get("theory") or {}).get("eurocode") or {}).get("limits") or []
        note += "".join(f" {limit}" for limit in limits)
    return ReportTable(tuple(head), tuple(rows), note)


def _read(run: Result, state: str, sides: tuple[str, ...], height_m: float) -> str:
    values = []
    for side in sides:
        height, stress = wall_profile(run, state, wall=side)
        inside = len(height) > 1 and height[0] <= height_m <= height[-1]
        values.append(kPa(float(np.interp(height_m, height, stress))) if inside else NONE)
    return " / ".join(values)


def hopper_table(run: Result) -> ReportTable | None:
    """Normal stresses on a hopper's walls at some heights, beside Walker's theory; None without its profiles."""
    if run.scene.silo.hopper is None or not len(run.profile("filling", "hopper_left")[0]):
        return None
    filled, flowing = _walker(run, "filling"), _walker(run, "discharge")
    unit, per_m = length_unit(run.scene.silo.height_m)
    head = (f"height ({unit})", "after filling", "Walker, filling", "in flow, N largest", "end of flow", "Walker, flow")
    rows = []
    for share in HOPPER_HEIGHTS:
        height = share * run.scene.silo.transition_m
        filling, maximum, residual = (_on_hopper(run, state, height) for state in STATES)
        row = (filling, _by_walker(filled, height), maximum, residual, _by_walker(flowing, height))
        rows.append((height_words(height, per_m), *row))
    cell = reading_of(run).hopper_cell_m
    note = f"Normal stress in kPa on the inclined walls, mean of both over {mm(cell)}; height over the outlet."
    limit = (run.summary.get("theory") or {}).get("walker_limit")
    return ReportTable(head, tuple(rows), note + (f" Walker's theory does not hold here: {limit}." if limit else ""))


def _on_hopper(run: Result, state: str, height_m: float) -> str:
    values = []
    for wall in ("hopper_left", "hopper_right"):
        height, stress = run.profile(state, wall)
        if len(height) > 1:
            values.append(np.interp(height_m, height, cell_mean(height, stress, reading_of(run).hopper_cell_m)))
    return kPa(float(np.mean(values))) if values else NONE


def _walker(run: Result, state: str) -> WalkerHopper | None:
    """Walker's theory below Janssen's at the law's own pressure ratio; None where it does not hold."""
    known = run.summary.get("janssen") or {}
    angle, ratio = known.get("wall_friction_angle_deg"), known.get("pressure_ratio_K0")
    if not angle or not ratio or not 0.0 < angle < 90.0:
        return None
    try:
        above = float(janssen_of(run.scene, angle, ratio).vertical_stress_Pa(straight_m(run)))
        return hopper_of(run.scene, angle, ratio, above, state)
    except ValueError:  # beyond the theory
        return None


def _by_walker(law: WalkerHopper | None, height_m: float) -> str:
    return NONE if law is None else kPa(float(law.normal_stress_Pa(law.outlet_height_m + height_m)))


def wall_zone_table(run: Result) -> ReportTable | None:
    """Table of the thickness of the shear zones along the walls; None if none was measured."""
    zones = run.summary.get("shear_zones") or {}
    rows = []
    for side in ("left", "right"):
        zone = zones.get(side) or {}
        if zone.get("thickness_m") is None:
            continue
        kind = "none" if not zone["thickness_m"] else "contractant" if zone.get("contractant") else "dilatant"
        quartiles = f"{_zone(zone.get('lower_quartile_m'))} to {_zone(zone.get('upper_quartile_m'))}"
        d50, thick = run.scene.sand.d50_m, zone["thickness_m"]
        rows.append((f"{side} wall", kind, _zone(thick), quartiles, number(thick / d50) if d50 and thick else NONE))
    if not rows:
        return None
    note = (
        "Zones along the vertical lines of the walls; beside a hopper there are none." if run.scene.silo.hopper else ""
    )
    return ReportTable(("zone along the", "kind", "thickness, median", "quartiles", "over d50"), tuple(rows), note)


def inner_zone_table(run: Result) -> ReportTable | None:
    """Table of the shear zones inside the sand; None if there are none."""
    zones = (run.summary.get("zones_inside") or {}).get("zones") or []
    head = ("zone", "kind", "length", "thickness", "over d50", "inclination", "radius of curvature")
    rows = []
    for count, zone in enumerate(zones, 1):
        bend = zone.get("curvature_1_per_m")
        radius = mm(abs(1.0 / bend), 2) if bend else NONE
        angle = zone.get("inclination_deg")
        angle = NONE if angle is None else f"{round(angle)}°".replace("-", "−")
        thickness = _zone(zone.get("thickness_m"))
        over = number(zone.get("thickness_over_d50"))
        rows.append((f"{count}", zone.get("kind") or NONE, _zone(zone.get("length_m")), thickness, over, angle, radius))
    return ReportTable(head, tuple(rows)) if rows else None


def _zone(length_m: float | None) -> str:
    """Length of a zone in mm, to three digits at most: nobody measures zones to less than a tenth of a mm."""
    return NONE if length_m is None else mm(length_m, 3)


def residence_table(run: Result) -> ReportTable | None:
    """Table of how long the sand stays in the silo; None where that was not measured."""
    found = run.summary.get("residence")
    if not found:
        return None
    head = ("of the sand", *(per_cent(float(level)) for level in found["over_plug"]), "never leaves")
    times = [number(value) for value in found["over_plug"].values()]
    note = (
        f"Time until that share of the leaving sand has left, over the time in which a silo that moves as one block "
        f"empties ({number(found['plug_time_s'])} s), if the flow went on as it is at the end."
    )
    return ReportTable(head, (("time over plug flow", *times, per_cent(found["never_share"])),), note)
