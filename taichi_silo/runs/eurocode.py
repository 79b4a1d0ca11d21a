"""EN 1991-4 for the silo of a scene, with the solid that the scene names."""

import math
from functools import lru_cache
from typing import Any

import numpy as np

from taichi_silo.analysis.theory.eurocode.bottoms import Bottom
from taichi_silo.analysis.theory.eurocode.solids import Solid
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.scene import polygons
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


def _hopper_of(silo: Silo) -> tuple[float, float] | None:
    """Half angle [deg] and width at the lower end [m] of a hopper, or of an outline whose two straight inclined walls
    are mirror images; None of every other bottom.
    """
    if silo.hopper is not None:
        return silo.hopper.half_angle_deg, silo.hopper.outlet_width_m
    left, right = (chain[chain[:, 1] <= silo.transition_m + polygons.SAME] for chain in silo.sides)
    mirrored = np.array([silo.width_m, 0.0]) + right * (-1.0, 1.0)
    if not (silo.transition_m and len(left) == len(right) == 2 and np.abs(left - mirrored).max() <= polygons.SAME):
        return None
    (into, low), (_, high) = left
    return (math.degrees(math.atan2(into, high - low)), silo.width_m - 2.0 * into) if into > 0.0 else None


def _apex_m(silo: Silo) -> float:
    """Height of the transition over the apex of a hopper, or over the outlet of an outline; 0 with a flat bottom."""
    hopper = _hopper_of(silo)
    return silo.transition_m if hopper is None else 0.5 * silo.width_m / math.tan(math.radians(hopper[0]))


def bottom_of(scene: Scene | Design, walls: EurocodeSilo) -> Bottom | None:
    """The floor or hopper of a scene's silo below its vertical walls; None below other inclined walls of an outline."""
    code, hopper = scene.eurocode, _hopper_of(scene.silo)
    if hopper is None:
        return None if scene.silo.transition_m else Bottom(walls, dynamic=code.dynamic)
    return Bottom(walls, *hopper, code.hopper_wall or walls.wall, code.dynamic)


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
