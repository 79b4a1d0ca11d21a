"""The tables of a report: forces, wall stresses and shear zones of the run, beside what theory says."""

from dataclasses import dataclass

import numpy as np

from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.report.states import FORCES, Force, forces_of, wall_profile
from taichi_silo.show.report.words import NONE, kN, kPa, mm, number, per_cent

HEIGHTS = (0.9, 0.75, 0.5, 0.25, 0.1)  # of the vertical walls, from the foot
TITLES = {
    "P": "bottom, P (kN/m)", "T": "wall friction, T (kN/m)", "N": "wall normal, N (kN/m)", "angle": "arctan(T/N) (°)",
}  # fmt: skip
ORIGINS = {"K0": "K₀ of the law", "measured": "K in the sand"}
WHEN = ("after filling", "in flow")
NAMES = {"K0 of the law": "K₀ of the law", "measured K": "K in the sand"}  # of `RunFiles.pressure_ratios`


@dataclass(frozen=True)
class Table:
    """Head, rows of words, and a note below; the first column names the rows."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def force_table(run: RunFiles) -> Table:
    """P, T, N and the wall friction angle in three states, and Janssen's theory after filling."""
    forces, theory = forces_of(run), run.summary.get("janssen") or {}
    origins = [key for key in ORIGINS if f"normal_N_per_m_{key}" in theory]
    head = ["force", "after filling", *(f"Janssen, {ORIGINS[key]}" for key in origins), "peak in flow", "end of flow"]
    rows = []
    for name, title in TITLES.items():
        one = forces[name]
        told = [_theory(one, theory, name, key) for key in origins]
        show = (lambda value: number(value)) if name == "angle" else kN
        peak = show(one.peak) if one.peak is None else f"{show(one.peak)} at u = {mm(one.peak_m, 3)}"
        rows.append((title, show(one.filled), *told, peak, show(one.residual)))
    for column in run.forces.columns:
        sideways = run.silo.section == "plane" and column.endswith("_horizontal_N_per_m")  # round: none in sum
        if sideways or column.endswith("_vertical_N_per_m"):
            rows.append(_of_body(run, column, len(origins)))
    return Table(tuple(head), tuple(rows), _force_note(run, theory))


def _theory(one: Force, theory: dict, name: str, key: str) -> str:
    if name == "angle":
        return number(theory.get("wall_friction_angle_deg"))
    value = theory.get(f"{FORCES[name][0]}_{key}")
    if value is None:
        return NONE
    if not one.filled:
        return kN(value)
    return f"{kN(value)} (run {per_cent(one.filled / value - 1.0, signed=True)})"


def _of_body(run: RunFiles, column: str, gap: int) -> tuple[str, ...]:
    """A hopper wall's or an insert's force on the sand, to the right or upwards."""
    words = column.removesuffix("_N_per_m").replace("_", " ")
    words = words.replace("hopper right", "hopper") if run.silo.section == "round" else words
    words = words.replace(" horizontal", ", to the right").replace(" vertical", ", upwards")
    filled = None if run.filled is None else run.filled.get(column)
    last = run.flow[column].iloc[-max(1, len(run.flow) // 20) :].mean() if len(run.flow) else None
    return (f"{words} (kN/m)", kN(filled), *[NONE] * gap, NONE, kN(last))


def _force_note(run: RunFiles, theory: dict) -> str:
    words = "T and N are means of both walls; the peak of P is its least value."
    if run.silo.section == "round":
        words += " Forces of the round silo are per metre of girth; P and the weight count two such metres."
    ratios = [
        f"{ORIGINS[key]} = {number(theory[f'pressure_ratio_{key}'])}"
        for key in ORIGINS
        if theory.get(f"pressure_ratio_{key}") is not None
    ]
    if ratios:
        angle = number(theory.get("wall_friction_angle_deg"))
        words += f" Janssen: wall friction {angle}°, {', '.join(ratios)} (in brackets: the run against it)."
    walker = [(run.summary.get("theory") or {}).get(f"walker_{state}") for state in ("filling", "discharge")]
    if all(walker):
        wall, outlet = (
            " and ".join(f"{kN(one[f'{part}_force_N_per_m'])} {when}" for when, one in zip(WHEN, walker, strict=True))
            for part in ("wall", "outlet")
        )
        who = "the wall carries" if run.silo.section == "round" else "each wall carries"
        words += f" Walker's theory of the hopper (kN/m): {who} {wall} upwards, the outlet {outlet}."
    return words


def stress_table(run: RunFiles) -> Table | None:
    """Wall normal stresses at some heights, with Janssen and EN 1991-4; None without wall profiles."""
    sides = ("left", "right") if run.lopsided else ("both",)
    if not len(wall_profile(run, "filling", wall=sides[0])[0]):
        return None
    straight = run.silo.height_m - run.transition_m
    heights = [run.transition_m + share * straight for share in HEIGHTS]
    laws = {origin: run.janssen(ratio) for origin, ratio in run.pressure_ratios.items()}
    theories = {f"Janssen, {NAMES.get(origin, origin)}": law for origin, law in laws.items() if law is not None}
    code = run.eurocode
    head = ["height (mm)", "after filling", *theories, *(["EN 1991-4, filling"] if code else [])]
    head += ["in flow, N largest", "end of flow", *(["EN 1991-4, discharge"] if code else [])]
    rows = []
    for height in heights:
        depth = run.silo.height_m - height
        read = {state: _read(run, state, sides, height) for state in ("filling", "maximum", "residual")}
        row = [f"{1e3 * height:.0f}", read["filling"]]
        row += [kPa(float(theory.normal_stress_Pa(depth))) for theory in theories.values()]
        row += [kPa(float(code.filling_normal_Pa(depth)))] if code else []
        row += [read["maximum"], read["residual"]]
        row += [kPa(float(code.discharge_normal_Pa(depth)))] if code else []
        rows.append(tuple(row))
    where = "left / right wall" if run.lopsided else "mean of both walls"
    note = f"Wall normal stress in kPa, as a pressure cell of 20 mm reads it, {where}; height above the initial bottom."
    if code:
        values = code.values()
        note += (
            f" EN 1991-4: {code.slenderness} silo, its table's sand on a {'D3' if run.wall_kind != 'smooth' else 'D2'} "
            "wall, characteristic values without patch loads. "
            f"Filling: γ = {values.weight_density_N_per_m3 / 1e3:g} kN/m³, K = {values.pressure_ratio:.3g}, μ = "
            f"{values.wall_friction:.3g}; discharge: C_h = {code.discharge_factors[0]:.3g} times that."
        )
        note += "".join(f" {limit}" for limit in _limits(run))
    return Table(tuple(head), tuple(rows), note)


def _limits(run: RunFiles) -> list[str]:
    return ((run.summary.get("theory") or {}).get("eurocode") or {}).get("limits") or []


def _read(run: RunFiles, state: str, sides: tuple[str, ...], height_m: float) -> str:
    values = []
    for side in sides:
        height, stress = wall_profile(run, state, wall=side)
        inside = len(height) > 1 and height[0] <= height_m <= height[-1]
        values.append(kPa(float(np.interp(height_m, height, stress))) if inside else NONE)
    return " / ".join(values)


def wall_zone_table(run: RunFiles) -> Table | None:
    """Thickness of the zones along the walls; None if none was measured."""
    zones = run.summary.get("shear_zones") or {}
    rows = []
    for side in ("left", "right"):
        zone = zones.get(side) or {}
        if zone.get("thickness_m") is None:
            continue
        kind = "none" if not zone["thickness_m"] else "contractant" if zone.get("contractant") else "dilatant"
        quartiles = f"{_zone(zone.get('lower_quartile_m'))} to {_zone(zone.get('upper_quartile_m'))}"
        d50, thick = run.parameter("sand", "d50_m"), zone["thickness_m"]
        rows.append((f"{side} wall", kind, _zone(thick), quartiles, number(thick / d50) if d50 and thick else NONE))
    if not rows:
        return None
    note = "Zones along the vertical lines of the walls; beside a hopper there are none." if run.silo.hopper else ""
    return Table(("zone along the", "kind", "thickness, median", "quartiles", "over d50"), tuple(rows), note)


def inner_zone_table(run: RunFiles) -> Table | None:
    """The zones inside; None if there are none."""
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
    return Table(head, tuple(rows)) if rows else None


def _zone(length_m: float | None) -> str:
    """In mm; nobody measures zones to less than a tenth of one."""
    return NONE if length_m is None else mm(length_m, 3)


def residence_table(run: RunFiles) -> Table | None:
    """How long the sand stays; None where that was not measured."""
    found = run.summary.get("residence")
    if not found:
        return None
    head = ("of the sand", *(per_cent(float(level)) for level in found["over_plug"]), "never leaves")
    times = [number(value) for value in found["over_plug"].values()]
    note = (
        f"Time until that share of the leaving sand has left, over the time in which a silo that moves as one block "
        f"empties ({number(found['plug_time_s'])} s), if the flow went on as it is at the end."
    )
    return Table(head, (("time over plug flow", *times, per_cent(found["never_share"])),), note)
