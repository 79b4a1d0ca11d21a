"""What was modelled, in a few lines."""

from taichi_silo.runs.result import Result
from taichi_silo.scene import bands
from taichi_silo.show.report.words import count, kN, mm, plain
from taichi_silo.utils.messages import counted

LAWS = {
    "gudehus-bauer": "Gudehus-Bauer hypoplasticity",
    "intergranular": "Gudehus-Bauer hypoplasticity with intergranular strain, a memory of the last strain",
}


def story(run: Result, sand: str) -> list[tuple[str, str]]:
    """Name and sentence of each part of the model; `sand` is the title of its sand."""
    return [
        ("Sand", _sand(run, sand)),
        ("Walls", _walls(run)),
        ("Filling", _filling(run)),
        ("Outflow", _outflow(run)),
        ("Method", _method(run)),
    ]


def _sand(run: Result, sand: str) -> str:
    scene, weight = run.scene, run.summary.get("weight_N_per_m")
    words = f"{sand}, void ratio {plain(scene.sand.void_ratio)}, bulk density {count(scene.density_kg_per_m3)} kg/m³. "
    words += f"Law: {LAWS.get(scene.sand.law, scene.sand.law)}."
    girth = "two metres of girth" if scene.silo.section == "round" else "a metre run"
    return words + (f" The sand of {girth} weighs {kN(weight)} kN." if weight else "")


def _walls(run: Result) -> str:
    side = "very rough: sand at the wall does not slip"
    if run.scene.walls.own:
        side = f"with a contact of a plugin, {run.scene.walls.kind}"
    elif run.scene.walls.kind == "smooth":
        side = f"smooth, Coulomb friction of {plain(run.scene.walls.friction_angle_deg)}°"
    if special := bands.words(run.scene.walls):
        side += f", in bands {special}"
    bottom, silo = run.scene.walls.bottom_friction_angle_deg, run.scene.silo
    words = f"Side walls {side}; {'bottom' if silo.floor_is_outlet else 'floor'} "
    words += f"with friction of {plain(bottom)}°" if bottom else "without friction"
    if special := silo.words():
        words += f". Special: {special}"
    return words + "."


def _filling(run: Result) -> str:
    filling, seconds = run.scene.filling, plain(run.scene.method.filling_time_s)
    if filling.kind == "layers":
        return f"{counted(filling.layers, 'layer')}, one after the other, each with its weight."
    if filling.kind == "rain":
        return f"Row after row falls from {mm(filling.drop_m)}."
    return f"The whole column is in place, and its weight grows within {seconds} s; then it comes to rest."


def _outflow(run: Result) -> str:
    flow = run.scene.flow
    if flow.outflow == "collapse":
        return "The walls of the column are taken away at once, and the sand spreads until it rests."
    if run.free:
        longest = plain(flow.longest_s)
        words = f"The outlet is opened and the sand falls out by its weight, until it stops or {longest} s have passed."
        return words + _times(run)
    what = "A gate in the outlet is lowered, and sand below the floor is taken away"
    what = "The whole bottom is lowered" if run.scene.silo.floor_is_outlet else what
    return f"{what}: {mm(flow.displacement_m)} at {plain(1e3 * flow.speed_m_per_s)} mm/s.{_times(run)}"


def _times(run: Result) -> str:
    """When the gates of several outlets open and close."""
    words = ""
    for number, outlet in enumerate(run.scene.silo.outlets):
        if outlet.timed:
            until = "" if outlet.closes_at_s is None else f" and begins to close after {plain(outlet.closes_at_s)} s"
            words += f" Gate {number + 1} opens after {plain(outlet.opens_at_s)} s{until}."
    return words


def _method(run: Result) -> str:
    grid, method, many = run.scene.grid, run.scene.method, run.scene.grid.points_per_cell
    points = (run.summary.get("cost") or {}).get("points")
    symmetry = "axial symmetry" if run.scene.silo.section == "round" else "plane strain"
    words = f"Explicit material point method, {symmetry}: cells of {mm(grid.cell_size_m)}, "
    words += f"{many} point{'s' if many != 1 else ''} a cell"
    words += f" ({count(points)} points computed)" if points else ""
    words += f"; shape functions {grid.shape}, transfer {method.transfer}"
    return f"{words}, stress updated {method.stress_update}."
