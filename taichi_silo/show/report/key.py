"""The numbers at the top of a report: what an engineer asks first."""

from dataclasses import dataclass

from taichi_silo.runs.result import Result
from taichi_silo.scene import fill_shape
from taichi_silo.show.report.states import (
    STATES,
    discharge_rate_kg_per_s_m,
    forces_of,
    largest_hopper_stress,
    largest_of_all,
    reading_of,
)
from taichi_silo.show.report.words import kN, kPa, mm, number, per_cent, plain, sentence

PATTERNS = {"mass": "mass flow", "mixed": "mixed flow", "funnel": "funnel flow"}


@dataclass(frozen=True)
class Card:
    """A key number: its name, its value with unit, and a sentence below."""

    name: str
    value: str
    unit: str
    words: str


def key_numbers(run: Result) -> list[Card]:
    """The key numbers that the files of a run tell."""
    cards = [_hopper(run), _stress(run), *_forces(run), _overpressure(run), _pattern(run), _discharge(run)]
    return [card for card in cards if card is not None]


def _stress(run: Result) -> Card | None:
    largest = largest_of_all(run)
    if largest is None:
        return None
    foot = "outlet" if run.scene.silo.hopper else "initial bottom" if run.scene.silo.floor_is_outlet else "floor"
    when = STATES.get(largest.state) or f"in flow at u = {mm(largest.displacement_m, 3)}"
    words = (
        f"{largest.wall} wall, {mm(largest.height_m, 3)} above the {foot}, {when}; as a pressure "
        f"cell of {mm(reading_of(run).cell_m)} reads it (one node: {kPa(largest.node_Pa)} kPa)"
    )
    name = "Largest pressure, vertical walls" if run.scene.silo.hopper else "Largest wall pressure"
    return Card(name, kPa(largest.stress_Pa), "kPa", sentence(words))


def _hopper(run: Result) -> Card | None:
    largest = largest_hopper_stress(run)
    if largest is None:
        return None
    words = (
        f"{largest.wall.removeprefix('hopper_')} hopper wall, {mm(largest.height_m, 3)} above the outlet, "
        f"{STATES[largest.state]}; mean over {mm(reading_of(run).hopper_cell_m)}"
    )
    flow = (run.summary.get("theory") or {}).get("walker_discharge")
    if flow:
        words += f" (Walker's theory: {kPa(flow['transition_normal_Pa'])} at the upper end, in flow)"
    return Card("Largest pressure, hopper", kPa(largest.stress_Pa), "kPa", sentence(words))


def _forces(run: Result) -> list[Card]:
    forces = forces_of(run)
    weight = run.summary.get("weight_N_per_m")
    below = "bottom" if run.scene.silo.floor_is_outlet else "outlet" if run.scene.silo.hopper else "floor and outlet"
    if run.scene.silo.column_m is not None:
        below = "floor"
    names = {"N": "Wall normal force N", "T": "Wall friction force T", "P": f"Force P on the {below}"}
    cards = []
    for name, title in names.items():
        one = forces[name]
        if name != "P" and not run.scene.silo.straight_m:  # no vertical walls; the table has the inclined ones
            continue
        shown = next((value for value in (one.peak, one.filled) if value is not None), None)
        if shown is None:
            continue
        each = "per metre of each wall" if name != "P" else "per metre"
        if one.peak is None or (name == "P" and run.free):  # an empty silo has the least P
            end = "" if one.residual is None else f"; {kN(one.residual)} at the end"
            cards.append(Card(title, kN(one.filled), "kN/m", sentence(f"after filling{end}; {each}")))
            continue
        extreme = "least" if name == "P" else "largest"
        of_weight = f", {per_cent(one.peak / weight)} of the sand's weight" if weight else ""
        words = (
            f"{extreme} value in flow{of_weight}, at u = {mm(one.peak_m, 3)}; {kN(one.filled)} after filling, "
            f"{kN(one.residual)} at the end; {each}"
        )
        cards.append(Card(title, kN(one.peak), "kN/m", sentence(words)))
    return cards


def _overpressure(run: Result) -> Card | None:
    found = run.summary.get("largest_overpressure")
    if not found:
        return None
    words = (
        f"times the pressure after filling, {found['wall']} wall {mm(found['height_m'], 3)} above the bottom at "
        f"that time, u = {mm(found['displacement_m'], 3)}: {kPa(found['normal_stress_Pa'])} instead of "
        f"{kPa(found['after_filling_Pa'])} kPa"
    )
    return Card("Over-pressure in flow", f"× {number(found['factor'])}", "", sentence(words))


def _pattern(run: Result) -> Card | None:
    found = run.summary.get("flow_pattern")
    if not found:
        return None
    kind = PATTERNS.get(found["kind"], found["kind"])
    left, right = found.get("transition_left_m"), found.get("transition_right_m")
    still = per_cent(found["stagnant_area_share"])
    if run.scene.silo.floor_is_outlet and run.scene.walls.kind == "very-rough":
        words = (
            "the whole bottom sinks, and the sand with it, but for what very rough walls hold: sand does not slip on "
            f"them; {still} of all sand stands still there"
        )
        return Card("Flow pattern", "Mass flow", "", sentence(words))
    if found["kind"] == "mass":
        words = "all the sand moves, along both walls"
    elif found["kind"] == "funnel":
        words = f"sand beside both walls stands still up to the surface; {still} of all sand is stagnant"
    else:
        walls = [
            f"{side} wall {'nowhere' if level is None else f'above {mm(level, 3)}' if level else 'everywhere'}"
            for side, level in (("left", left), ("right", right))
        ]
        words = f"sand moves along the {', along the '.join(walls)}; {still} of all sand is stagnant"
    return Card("Flow pattern", kind.capitalize(), "", sentence(words))


def _discharge(run: Result) -> Card | None:
    flow = run.scene.flow
    if run.scene.silo.floor_is_outlet:
        depth = mm(flow.displacement_m)
        words = f"the whole bottom sinks by {depth}; the sand stays on it, so the flow has no rate of discharge"
        return Card("Outflow", plain(1e3 * flow.speed_m_per_s), "mm/s", sentence(words))
    if flow.outflow == "collapse":
        return _run_out(run)
    rate = discharge_rate_kg_per_s_m(run)
    if rate is None:
        return None
    theory = (run.summary.get("theory") or {}).get("beverloo_kg_per_s_m")
    free = f"; Beverloo's formula gives {number(theory)}" if theory else ""
    if run.free:
        return Card("Discharge rate", number(rate), "kg/s per m", sentence(f"while 10 to 50 % of the sand leave{free}"))
    words = f"mean of the whole flow, driven by a gate that sinks at {plain(1e3 * flow.speed_m_per_s)} mm/s"
    if theory:
        words += f"; falling freely (Beverloo) it would be {number(theory)}"
    return Card("Discharge rate", number(rate), "kg/s per m", sentence(words))


def _run_out(run: Result) -> Card | None:
    found = run.summary.get("collapse")
    if not found:
        return None
    words = (
        f"(L − L₀) / L₀ of a column with H₀ / L₀ = {number(found['aspect_ratio'])}; it rests with H / L₀ = "
        f"{number(found['height_over_L0'])} and a slope of {number(found['slope_deg'])}°"
    )
    return Card("Run-out", number(found["run_out_over_L0"]), "L₀", words)


def in_one_sentence(run: Result) -> str:
    """Say in one sentence what was computed; it stands below the title."""
    silo, flow = run.scene.silo, run.scene.flow
    body = f"A round silo {mm(silo.width_m)} in diameter" if silo.section == "round" else (
        f"A silo between parallel walls {mm(silo.width_m)} apart"
    )  # fmt: skip
    words = f"{body}, filled {mm(silo.height_m)} high"
    if flow.outflow == "collapse":
        left, right = fill_shape.sides_m(silo)
        return (
            f"A column of sand, {mm(right - left)} wide and {mm(silo.height_m)} high, whose walls are taken away on a "
            f"floor {mm(silo.width_m)} wide."
        )
    if run.free:
        return f"{words}; the outlet is opened and the sand falls out."
    what = "whole bottom is lowered" if silo.floor_is_outlet else "gate in the outlet sinks"
    return f"{words}; the {what} by {mm(flow.displacement_m)} at {plain(1e3 * flow.speed_m_per_s)} mm/s."
