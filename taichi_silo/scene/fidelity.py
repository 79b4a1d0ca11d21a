"""Named settings between cheap and accurate, in units of the scene, and what the chart measured of each.

A fidelity is a number of cells across the silo and a Froude number of the bottom, v / sqrt(g b), so that it means the
same in a silo of any size. `measured_errors.toml`, left by `python -m validation.accuracy`, has the errors of each in
scenes of the model silo; they hold for scenes of the same kind, and for others none are told.
"""

import math
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.scene import cell_sizes
from taichi_silo.scene.averaging import Averaging
from taichi_silo.scene.flow import FASTEST_M_PER_S, slow_speed_m_per_s
from taichi_silo.scene.mesh import Mesh
from taichi_silo.scene.scene import Method, Scene

FILE = Path(__file__).with_name("measured_errors.toml")
STANDARD = "standard"  # the one whose values are the defaults of a scene
SMOOTH_DEG, ROUGH_DEG = 21.0, 35.0  # friction angles of walls up to which a scene is of the kind "smooth", "rough"
SHAPES = (1.25, 5.0)  # height over width of scenes like the chart's, which have 2.5
FLOOR, STEEP_DEG = "floor", 30.0  # the whole floor sinks; half angle of a hopper in which all sand flows
DENSE = 0.5  # of the way from the densest to the critical void ratio: what is still of the kind "dense"
SAME = 1e-3  # relative difference of settings that counts as none


@dataclass(frozen=True)
class Fidelity:
    """Cells across a silo, and how many times faster its bottom sinks than where a slower one changes nothing."""

    across: float
    hurry: float

    def values(self, scene: Scene) -> dict[str, float]:
        """Size of the cells [m] and speed of the bottom [m/s] by their paths, for the silo of a scene."""
        silo = scene.silo
        slow = slow_speed_m_per_s(silo.width_m, scene.method.gravity_m_per_s2)
        across = max(self.across, cell_sizes.wanted_across(silo) * self.across / cell_sizes.ACROSS)
        cell = cell_sizes.nearest(silo, across) or silo.width_m / across
        return {"grid.cell_size_m": cell, "flow.speed_m_per_s": min(self.hurry * slow, FASTEST_M_PER_S)}


FIDELITIES = {
    "draft": Fidelity(20, 4.0), STANDARD: Fidelity(cell_sizes.ACROSS, 1.0), "fine": Fidelity(100, 4.0),
    "converged": Fidelity(130, 4.0),
}  # fmt: skip


def fidelity(name: str) -> Fidelity:
    """The named setting of that name.

    Raises BadInput if there is none.
    """
    if name not in FIDELITIES:
        raise BadInput(f"fidelity is {name}; it must be one of {', '.join(FIDELITIES)}")
    return FIDELITIES[name]


def like(scene: Scene) -> str | None:
    """The name of the setting, if any, whose cells and speed a scene has, all else of its method being the default."""
    usual = scene.model_copy(update={"averaging": Averaging()}).characteristic_length_m
    usual_mesh = Mesh(cell_size_m=scene.grid.cell_size_m).fitted(scene.silo, scene.flow.outflow == "gravity")
    others = Method(gravity_m_per_s2=scene.method.gravity_m_per_s2)
    if (
        (scene.grid.points_per_cell, scene.grid.shape) != (usual_mesh.points_per_cell, usual_mesh.shape)
        or not math.isclose(scene.characteristic_length_m, usual, rel_tol=SAME)
        or scene.method != others
    ):
        return None
    for name, one in FIDELITIES.items():
        wanted = one.values(scene)
        own = {"grid.cell_size_m": scene.grid.cell_size_m, "flow.speed_m_per_s": scene.flow.speed_m_per_s}
        if all(math.isclose(own[path], value, rel_tol=SAME) for path, value in wanted.items()):
            return name
    return None


def kind(scene: Scene) -> str | None:
    """The scene of the chart that a scene is like: walls or openings, and how dense its sand is; None if like none."""
    sand, walls, shape = scene.sand, scene.walls, _shape(scene)
    dense = sand.void_ratio <= sand.e_d0 + DENSE * (sand.e_c0 - sand.e_d0)
    density = "loose" if sand.loose else "dense" if dense else None
    angle, limits = walls.friction_angle_deg, {"smooth": SMOOTH_DEG, "rough": ROUGH_DEG}
    wall = walls.kind if angle is None else next((name for name, most in limits.items() if angle <= most), None)
    name = f"{wall} {density}" if shape == FLOOR else f"{shape} {density}" if wall == "smooth" else ""
    return name if name in _all()["errors"] else None


def _shape(scene: Scene) -> str | None:
    """What is below the sand, or in it, as scenes of the chart have it: one thing at most; None for all else."""
    silo = scene.silo
    odd = silo.section != "plane" or silo.outline_m is not None or silo.column_m is not None
    odd |= silo.surface_m is not None or bool(scene.walls.bands) or scene.flow.outflow == "gravity"
    parts = [*(["hopper"] if silo.hopper else []), *(["insert"] * len(silo.inserts))]
    if odd or len(silo.outlets) > 1 or len(parts) > 1 or not SHAPES[0] <= silo.height_m / silo.width_m <= SHAPES[1]:
        return None
    if silo.hopper and silo.hopper.half_angle_deg > STEEP_DEG:
        return None
    return parts[0] if parts else FLOOR if silo.floor_is_outlet else "outlet"


@dataclass(frozen=True)
class Measured:
    """Errors of P, T and N at the end over the weight, of a fidelity in scenes of a kind."""

    kind: str
    P: float
    T: float
    N: float
    known_to: float  # error bar of what they were measured against, the largest

    def words(self) -> str:
        """In a part of a sentence."""
        errors = ", ".join(f"{name} {100.0 * getattr(self, name):.2g} %" for name in "PTN")
        bar = f"{100.0 * self.known_to:.2g} %"
        return f"errors in scenes like this ({self.kind}): {errors} of the weight, known to ± {bar}"


def measured(scene: Scene, name: str) -> Measured | None:
    """What was measured of a named setting in scenes like this one; None if nothing was."""
    like_this = kind(scene)
    found = _all()["errors"].get(like_this, {}).get(name) if like_this else None
    return Measured(kind=like_this, **found) if like_this and found else None


def told(scene: Scene) -> str:
    """What a scene's cells and speed are, and what errors they make, in a sentence."""
    name = like(scene)
    across = round(scene.silo.width_m / scene.grid.cell_size_m)
    own = f"{across} cells across"
    if scene.flow.outflow == "controlled":
        own = f"{own}, {1e3 * scene.flow.speed_m_per_s:g} mm/s"
    found = measured(scene, name) if name else None
    words = found.words() if found else "no errors were measured in scenes like this; taichi-silo converge finds them"
    return f"Fidelity {name}: {own}; {words}." if name else f"{own[:1].upper()}{own[1:]}; {words}."


def change(scene: Scene, part: str) -> str:
    """What a part of the method changes in scenes like this one, in a sentence; empty if that was not measured."""
    like_this = kind(scene)
    found = _all()["changes"].get(like_this, {}).get(part) if like_this else None
    if found is None:
        return ""
    return (
        f" In scenes like this ({like_this}) it changes P, T and N at the end by {100.0 * found:.2g} % of the weight."
    )


@cache
def _all() -> dict[str, dict[str, dict[str, Any]]]:
    """Of each scene of the chart: "errors" of each fidelity, and "changes" by each part of the method."""
    return tomllib.loads(FILE.read_text(encoding="utf-8"))
