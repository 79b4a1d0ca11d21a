"""No more than a scene needs: which parts of the method a scene uses, why, and the flag that says otherwise.

Each part decides where it lives (`averaging.py`, `symmetry.py`, `scene.py`, ...); here the decisions are gathered, each
with the number behind it. What a scene does not use is compiled out.
"""

import math
from dataclasses import dataclass
from typing import Any

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws.integrate import LOCAL_ERROR
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.scene import cell_sizes, fidelity
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.stress_filter import filter_of
from taichi_silo.scene.symmetry import half_model
from taichi_silo.simulation.discretise import rows_of_cells
from taichi_silo.simulation.section import Section
from taichi_silo.simulation.time_scales import noise_control, period_of

TOUCHING = 3.75  # stretch along an axis at which points that keep their domain lose touch (stability map, ugimp)

KEYS = {  # of a scene file, by the flags of scenarios that set the same
    "--fidelity": "grid.cell_size_m, flow.speed_m_per_s", "--cell-size": "grid.cell_size_m",
    "--longest": "flow.longest_s", "--displacement": "flow.displacement_m", "--speed": "flow.speed_m_per_s",
    "--law": "sand.law", "--characteristic-length": "averaging.characteristic_length_m", "--half": "silo.half",
    "--filter": "method.stress_filter", "--shape": "grid.shape", "--walls": "walls.kind",
    "--noise-control": "method.noise_control", "--records-per-period": "output.records_per_period",
    "--snapshots": "output.snapshots",
}  # fmt: skip


@dataclass(frozen=True)
class Part:
    """One decision.

    Attributes
    ----------
    part : what it is about.
    choice : "on", "off", or what was chosen.
    because : a sentence with the number behind it.
    flag : of a scenario, that overrules it; empty if nothing does.

    """

    part: str
    choice: str
    because: str
    flag: str = ""

    @property
    def key(self) -> str:
        """What overrules it in a scene file: keys with their tables; empty if nothing does."""
        return ", ".join(KEYS[word] for word in self.flag.replace(",", "").split() if word in KEYS)


def parts(scene: Scene) -> list[Part]:
    """The decisions for a scene; Taichi has been started."""
    period = period_of(scene)
    return [
        accuracy(scene),
        cell_size(scene),
        outflow(scene),
        intergranular_strain(scene),
        non_local_average(scene),
        half(scene),
        sub_stepping(scene),
        stress_filter(scene),
        domains(scene),
        wall_friction(scene),
        noise(scene, period),
        records(scene, period),
        empty_nodes(scene),
        sand_at_rest(scene),
    ]


def _on(choice: bool) -> str:
    return "on" if choice else "off"


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:]


def accuracy(scene: Scene) -> Part:
    """What was measured of cells and speed in scenes of this kind."""
    own, others, bar = fidelity.like(scene), [], ""
    for name in fidelity.FIDELITIES:
        found = fidelity.measured(scene, name)
        if found is not None:
            others.append(f"{name} {100.0 * max(found.P, found.T, found.N):.2g} %")
            bar = f"known to ± {100.0 * found.known_to:.2g} %"
    because = "No errors were measured in scenes like this; taichi-silo converge finds them."
    if others:
        kind = fidelity.kind(scene)
        because = (
            f"Largest errors of P, T and N over the weight in scenes like this ({kind}): {', '.join(others)}; {bar}."
        )
    return Part("accuracy", own or "of its own", because, "--fidelity")


def cell_size(scene: Scene) -> Part:
    """As given, or chosen to fit the silo."""
    silo, h = scene.silo, scene.grid.cell_size_m
    narrow = cell_sizes.narrowest_m(silo)
    why = "Not given, so chosen to fit" if "cell_size_m" in scene.grid.chosen else "As given"
    because = (
        f"{why}: {round(silo.width_m / h)} cells across, {round(silo.height_m / scene.cell_height_m)} along the "
        f"height, {narrow / h:.3g} across the outlet."
    )
    if (count := scene.grid.points_per_cell) > 1:
        because += f" {count} points in each."
    return Part("cell size", f"{1e3 * h:.6g} mm", because, "--cell-size")


def outflow(scene: Scene) -> Part:
    """Speed and displacement, as given or chosen by the size of the silo."""
    flow, wide = scene.flow, scene.silo.width_m
    if flow.outflow == "collapse":
        because = f"As asked for: the walls of the column are taken away at once, for {flow.longest_s:g} s at most."
        return Part("outflow", "collapses", because, "--longest")
    if flow.free:
        until = f"until a gate would have sunk by {1e3 * flow.displacement_m:g} mm"
        because = f"As asked for: {until}, for {flow.longest_s:g} s at most."
        return Part("outflow", "falls freely", because, "--displacement")
    froude = flow.speed_m_per_s / math.sqrt(scene.method.gravity_m_per_s2 * wide)
    ratios = {
        "speed_m_per_s": f"speed {{}}: {froude:.3g} of the root of gravity and width",
        "displacement_m": f"displacement {{}}: {flow.displacement_m / wide:.3g} of the width",
    }
    told = [words.format("chosen" if name in flow.chosen else "as given") for name, words in ratios.items()]
    choice = f"{1e3 * flow.speed_m_per_s:g} mm/s, {1e3 * flow.displacement_m:g} mm"
    return Part("outflow", choice, _sentence("; ".join(told)) + ".", "--speed, --displacement")


def intergranular_strain(scene: Scene) -> Part:
    """A memory of the last strain, where strain turns back."""
    sand, flow = scene.sand, scene.flow
    if sand.law != "auto":
        because = f"As asked for: {sand.law}."
    elif flow.turns_back:
        because = f"Strain turns back, and sand is then {sand.intergranular.m_R:g} times as stiff (m_R)."
    elif scene.silo.has_opening:
        because = (
            f"The gate lets the sand go one way, at {1e3 * flow.speed_m_per_s:g} mm/s; only free outflow turns strain "
            "back."
        )
    else:
        strain = flow.displacement_m / scene.silo.height_m
        because = (
            f"Nothing turns the strain back: the bottom sinks one way by u / H = {strain:.2g}, "
            f"{strain / sand.intergranular.radius:.3g} times the strain R over which sand forgets."
        )
    return Part("intergranular strain", _on(scene.law.REMEMBERS), because, "--law")


def non_local_average(scene: Scene) -> Part:
    """Off where a point's own weight is nearly 1."""
    kernel, because = scene.averaging.kernel(scene.characteristic_length_m, scene.spacing_m)
    because += fidelity.change(scene, "non-local average")
    return Part("non-local average", _on(kernel is not None), because, "--characteristic-length")


def half(scene: Scene) -> Part:
    """One half of a symmetric silo."""
    on, because = half_model(scene)
    return Part("half model", _on(on), because, "--half")


def sub_stepping(scene: Scene) -> Part:
    """Of the stress, for each point and step anew."""
    because = (
        f"Only points divide a step whose stress Euler's rule would miss by more than {LOCAL_ERROR:g} of itself; one "
        "step of Heun's does for all others."
    )
    return Part("stress sub-stepping", "where needed", because)


def stress_filter(scene: Scene) -> Part:
    """Of patterns of stress that no node feels."""
    name, because = filter_of(scene)
    return Part("stress filter", name, because, "--filter")


def domains(scene: Scene) -> Part:
    """Domains of points that stretch with the sand."""
    name, sand = scene.grid.shape, scene.sand
    if SHAPES[name].DOMAIN:
        return Part("particle domains", "on", f"The shape {name} convects those of all points.", "--shape")
    stretch = (1.0 + max(sand.e_c0, sand.void_ratio)) / (1.0 + sand.void_ratio)
    because = (
        f"The shape {name} needs none: shearing dilates sand {stretch:.2f} times at most (to e_c0), and points that "
        f"keep their domain lose touch at a stretch of {TOUCHING}."
    )
    return Part("particle domains", "off", because, "--shape cpgimp | cpdi")


def wall_friction(scene: Scene) -> Part:
    """A friction solve at each node of a wall that is neither very rough nor frictionless."""
    silo = scene.silo
    angles: dict[str, float | None] = {"bottom": scene.walls.bottom_friction_angle_deg}
    if scene.walls.kind == "smooth":
        angles = {"side": scene.walls.friction_angle_deg} | angles
    own: list[tuple[str, Any]] = [("hopper", silo.hopper)] if silo.hopper else []
    own += [(insert.kind, insert) for insert in silo.inserts]
    angles |= {name: body.friction_angle_deg for name, body in own if body.friction_angle_deg is not None}
    because = "; ".join(f"{name}: {_friction(angle)}" for name, angle in angles.items()) + "."
    if scene.walls.kind == "very-rough":
        because = f"side: very rough, sand does not slip; {because}"
    return Part("wall friction solve", _on(any(angles.values())), _sentence(because), "--walls")


def _friction(angle_deg: float | None) -> str:
    return f"Coulomb's, {angle_deg:g} deg" if angle_deg else "0 deg, only the normal is solved"


def noise(scene: Scene, period_s: float) -> Part:
    """Against the column's own oscillation."""
    control = noise_control(scene, period_s)
    swing = f"the column swings with {1e3 * period_s:.3g} ms (4H/c)"
    if not control.drag:
        return Part("noise control", "off", f"As asked for: {swing}, and nothing holds it.", "--noise-control")
    because = f"{swing}; drag {control.rates('flow')[0]:.3g} /s towards the mean of {1e3 * control.memory_time:.3g} ms."
    return Part("noise control", "on", _sentence(because), "--noise-control")


def records(scene: Scene, period_s: float) -> Part:
    """How often forces are written."""
    interval = period_s / scene.output.records_per_period
    flow = scene.flow.displacement_m / scene.flow.speed_m_per_s
    because = (
        f"{scene.output.records_per_period} records a period of the column, about {flow / interval:.0f} in flow; "
        f"{scene.snapshots} snapshots of flow are for films of other fields."
    )
    flags = "--records-per-period, --no-film, --snapshots"
    return Part("output", f"a record every {1e3 * interval:.3g} ms", because, flags)


def empty_nodes(scene: Scene) -> Part:
    """Nodes without sand are not integrated."""
    h = scene.grid.cell_size_m
    across = round(Section.of(scene).width / h)
    filled = round((across + 1) * (scene.silo.height_m / h + 1) * scene.silo.area_m2 / scene.silo.box_m2)
    nodes = (across + 1 + 2 * MARGIN) * (rows_of_cells(scene) + 1 + 2 * MARGIN)
    because = f"{filled} of {nodes} nodes lie in the sand at the start; a node without mass is passed over."
    return Part("inactive cells", "skipped", because)


def sand_at_rest(scene: Scene) -> Part:
    """Nothing rests above a bottom that sinks as a whole; beside an outlet sand does, but waves cross it."""
    because = f"0 of {scene.points} points rest: the whole fill sinks with the bottom."
    if scene.silo.column_m is not None:
        because = "What has come to rest carries what still slides over it."
    elif scene.silo.has_opening:
        because = (
            f"Sand beside the outlet of {1e3 * cell_sizes.narrowest_m(scene.silo):g} mm may rest, but it carries what "
            "moves: its stress changes in every step."
        )
    return Part("sand at rest", "stepped", because)
