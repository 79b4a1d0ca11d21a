"""What was modelled, in a few lines."""

from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.report.words import NONE, count, kN, mm, plain

LAWS = {
    "gudehus-bauer": "Gudehus-Bauer hypoplasticity",
    "intergranular": "Gudehus-Bauer hypoplasticity with intergranular strain, a memory of the last strain",
}


def story(run: RunFiles, sand: str) -> list[tuple[str, str]]:
    """Name and sentence of each part of the model.

    Parameters
    ----------
    run : of a silo.
    sand : its title.

    """
    return [
        ("Sand", _sand(run, sand)),
        ("Walls", _walls(run)),
        ("Filling", _filling(run)),
        ("Outflow", _outflow(run)),
        ("Method", _method(run)),
    ]


def _sand(run: RunFiles, sand: str) -> str:
    law = run.parameter("sand", "law", "")
    grains, weight = run.parameter("sand", "grain_density_kg_per_m3"), run.summary.get("weight_N_per_m")
    words = [f"{sand}, void ratio {plain(run.void_ratio)}"]
    if grains and run.void_ratio == run.void_ratio:
        words[0] += f", bulk density {count(grains / (1.0 + run.void_ratio))} kg/m³"
    words.append(f"Law: {LAWS.get(law, law)}")
    if weight:
        girth = "two metres of girth" if run.silo.section == "round" else "a metre run"
        words.append(f"The sand of {girth} weighs {kN(weight)} kN")
    return ". ".join(words) + "."


def _walls(run: RunFiles) -> str:
    side = "very rough: sand at the wall does not slip"
    if run.wall_kind == "smooth":
        side = f"smooth, Coulomb friction of {plain(run.parameter('walls', 'friction_angle_deg'))}°"
    bottom = run.parameter("walls", "bottom_friction_angle_deg", 0.0)
    words = f"Side walls {side}; {'bottom' if run.silo.floor_is_outlet else 'floor'} "
    words += f"with friction of {plain(bottom)}°" if bottom else "without friction"
    if special := run.silo.words():
        words += f". Special: {special}"
    return words + "."


def _filling(run: RunFiles) -> str:
    kind = run.parameter("filling", "kind", "")
    seconds = plain(run.parameter("method", "filling_time_s"))
    if kind == "layers":
        return f"{run.parameter('filling', 'layers', NONE)} layers, one after the other, each with its weight."
    if kind == "rain":
        return f"Row after row falls from {mm(run.parameter('filling', 'drop_m'))}."
    return f"The whole column is in place, and its weight grows within {seconds} s; then it comes to rest."


def _outflow(run: RunFiles) -> str:
    depth, speed = run.parameter("flow", "displacement_m"), run.parameter("flow", "speed_m_per_s")
    if run.free:
        longest = plain(run.parameter("flow", "longest_s"))
        return f"The outlet is opened and the sand falls out by its weight, until it stops or {longest} s have passed."
    what = "A gate in the outlet is lowered, and sand below the floor is taken away"
    what = "The whole bottom is lowered" if run.silo.floor_is_outlet else what
    pace = f" at {plain(1e3 * speed)} mm/s" if speed else ""
    return f"{what}: {mm(depth)}{pace}."


def _method(run: RunFiles) -> str:
    cell, many = run.parameter("grid", "cell_size_m"), run.parameter("grid", "points_per_cell", 1)
    points = (run.summary.get("cost") or {}).get("points")
    words = f"Explicit material point method, {'axial symmetry' if run.silo.section == 'round' else 'plane strain'}: "
    words += f"cells of {mm(cell)}, {many} point{'s' if many != 1 else ''} a cell"
    words += f" ({count(points)} points computed)" if points else ""
    shape, transfer = run.parameter("grid", "shape", NONE), run.parameter("method", "transfer", NONE)
    order = run.parameter("method", "stress_update", NONE)
    return f"{words}; shape functions {shape}, transfer {transfer}, stress updated {order}."
