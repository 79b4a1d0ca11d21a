"""EN 1991-4 for the silo of a scene, with the solid that the scene names."""

import math
from functools import lru_cache
from typing import Any

from taichi_silo.analysis.theory.eurocode.bottoms import Bottom
from taichi_silo.analysis.theory.eurocode.solids import Solid
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.scene.design import Design
from taichi_silo.scene.published_solids import published
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.silo import Silo


@lru_cache
def solids() -> dict[str, Solid]:
    """All solids of table E.1 by name."""
    return {name: Solid(**{key: row[key] for key in Solid.__dataclass_fields__}) for name, row in published().items()}


def eurocode_of(scene: Scene | Design) -> EurocodeSilo | None:
    """The vertical walls of a scene's silo after EN 1991-4, with the solid that it names; None without such walls."""
    silo, code = scene.silo, scene.eurocode
    height = silo.straight_m
    if not height:
        return None
    eccentricity = silo.eccentricity_m
    return EurocodeSilo(
        silo.width_m, height, Solid(**code.stored), wall=code.wall or ("D2" if scene.walls.kind == "smooth" else "D3"),
        section=silo.section, length_m=code.length_m, filling_eccentricity_m=code.filling_eccentricity_m,
        outlet_eccentricity_m=eccentricity if code.outlet_eccentricity_m is None else code.outlet_eccentricity_m,
        action_class=code.action_class, wall_contact=code.wall_contact_factor, from_top=code.from_top,
        hopper_height_m=_apex_m(silo),
    )  # fmt: skip


def _apex_m(silo: Silo) -> float:
    """Height of the transition over the apex of a hopper, or over the outlet of an outline; 0 with a flat bottom."""
    if silo.hopper is None:
        return silo.transition_m
    return 0.5 * silo.width_m / math.tan(math.radians(silo.hopper.half_angle_deg))


def bottom_of(scene: Scene | Design, walls: EurocodeSilo) -> Bottom | None:
    """The floor or hopper of a scene's silo below its vertical walls; None below an outline's inclined walls."""
    silo, code = scene.silo, scene.eurocode
    if silo.hopper is None:
        return None if silo.transition_m else Bottom(walls, dynamic=code.dynamic)
    angle, outlet = silo.hopper.half_angle_deg, silo.hopper.outlet_width_m
    return Bottom(walls, angle, outlet, code.hopper_wall or walls.wall, code.dynamic)


def whose_numbers(scene: Scene | Design) -> str:
    """A sentence on the solid that EN 1991-4's numbers are for, and the sand that is simulated."""
    solid, sand = Solid(**scene.eurocode.stored), scene.sand
    low, high = solid.lower_weight_density_N_per_m3 / 1e3, solid.upper_weight_density_N_per_m3 / 1e3
    own = sand.grain_density_kg_per_m3 / (1.0 + sand.void_ratio) * scene.method.gravity_m_per_s2 / 1e3
    return (
        f"EN 1991-4's numbers are those of its solid {solid.title} ({low:g} to {high:g} kN/m³, internal friction "
        f"{solid.internal_friction_angle_deg:g}°); the simulated sand is another one: {sand.name} ({own:.3g} kN/m³ "
        f"at a void ratio of {sand.void_ratio:g}, critical friction angle {sand.critical_friction_angle_deg:g}°)."
    )


def eurocode_findings(scene: Scene) -> dict[str, Any]:
    """What EN 1991-4 gives at the foot of the vertical walls, for a summary."""
    code = eurocode_of(scene)
    if code is None:
        return {}
    deepest, bottom = code.height_m, bottom_of(scene, code)
    found = {
        "solid": code.solid.title, "wall": code.wall, "whose_numbers": whose_numbers(scene),
        "slenderness": code.slenderness, "limits": code.limits(),
        "discharge_factors": list(code.discharge_factors),
        "filling_normal_Pa": float(code.filling_normal_Pa(deepest)),
        "discharge_normal_Pa": float(code.discharge_normal_Pa(deepest)),
        "discharge_shear_Pa": float(code.discharge_shear_Pa(deepest)),
        "large_eccentricity": code.is_eccentric,
    }  # fmt: skip
    if bottom is not None:
        found |= {"bottom": bottom.kind, "transition_vertical_Pa": bottom.transition_Pa}
    return found
