"""Janssen, Walker, EN 1991-4 and Beverloo for the silo of a scene, with its own numbers."""

import math
from typing import Any

import numpy as np

from taichi_silo.analysis.theory import beverloo
from taichi_silo.analysis.theory.banded_janssen import BandedJanssen
from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.analysis.theory.walker import WalkerHopper
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.runs.eurocode import eurocode_findings
from taichi_silo.scene import bands
from taichi_silo.scene.scene import Scene


def janssen_of(scene: Scene, angle_deg: float, pressure_ratio: float) -> Janssen:
    """Janssen's theory of the part with vertical walls; through the bands of walls whose friction changes."""
    silo = scene.silo
    density = scene.density_kg_per_m3 * scene.method.gravity_m_per_s2
    if scene.walls.bands:
        return BandedJanssen.through(silo.width_m, density, pressure_ratio, silo.section, layers_of(scene))
    return Janssen(silo.width_m, silo.straight_m, density, angle_deg, pressure_ratio, section=silo.section)


def layers_of(scene: Scene) -> tuple[tuple[float, float], ...]:
    """Height [m] and mean friction coefficient of both walls of each layer of the vertical part, from the surface down.

    Where a wall is very rough it is that of critical simple shear.
    """
    silo, walls = scene.silo, scene.walls
    heights = bands.levels(walls, silo.transition_m, silo.height_m)
    low, high = heights[:-1], heights[1:]
    rough = math.tan(math.radians(critical_simple_shear_angle_deg(scene.sand.critical_friction_angle_deg)))
    both = [bands.coefficient(walls, wall, low, high) for wall in ("left", "right")]
    mean = np.mean([np.where(mu < 0.0, rough, mu) for mu in both], axis=0)
    return tuple(zip((high - low)[::-1].tolist(), mean[::-1].tolist(), strict=True))


def critical_simple_shear_angle_deg(critical_friction_angle_deg: float) -> float:
    """Arctan(shear / normal stress) of the Gudehus-Bauer law in critical simple shear [degrees].

    All normal stresses are then equal, cos(3 theta) is 0 and the stress deviator's norm is x = a1, where
    1 / a1 = c1 + c2 x; the ratio is 3 x / sqrt(2). Values of c1 and c2: Bauer (1996).
    """
    law = GudehusBauer(critical_friction_angle_deg=critical_friction_angle_deg)
    x = (math.sqrt(law.c1**2 + 4.0 * law.c2) - law.c1) / (2.0 * law.c2)
    return math.degrees(math.atan(3.0 * x / math.sqrt(2.0)))


def hopper_of(
    scene: Scene, angle_deg: float, pressure_ratio: float, transition_stress_Pa: float, state: str
) -> WalkerHopper:
    """Walker's theory of the hopper below the vertical walls; `state` is "filling" or "discharge"."""
    silo, hopper = scene.silo, scene.silo.hopper
    assert hopper is not None, "the silo has no hopper"
    own = hopper.friction_angle_deg
    if own is None and scene.walls.bands:
        both = [bands.coefficient(scene.walls, wall, 0.0, silo.transition_m) for wall in ("left", "right")]
        own = math.degrees(math.atan(float(np.mean(both)))) if min(both) >= 0.0 else None
    return WalkerHopper(
        silo.width_m, hopper.outlet_width_m, hopper.half_angle_deg,
        scene.density_kg_per_m3 * scene.method.gravity_m_per_s2, angle_deg if own is None else own,
        transition_stress_Pa, state=state, section=silo.section,
        internal_friction_angle_deg=scene.sand.critical_friction_angle_deg, pressure_ratio=pressure_ratio,
    )  # fmt: skip


def theory_of(scene: Scene, angle_deg: float, pressure_ratio: float) -> dict:
    """Pressures, forces and rates that the theories give for a scene's silo, for its summary.

    Parameters
    ----------
    scene : of the run.
    angle_deg : of wall friction; the mobilised one where walls are very rough.
    pressure_ratio : K between the vertical walls.

    """
    silo, g = scene.silo, scene.method.gravity_m_per_s2
    found: dict[str, Any] = {"outlet_eccentricity_m": silo.eccentricity_m}
    if code := eurocode_findings(scene):
        found["eurocode"] = code
    if silo.hopper is not None and 0.0 < angle_deg < 90.0:
        above = float(janssen_of(scene, angle_deg, pressure_ratio).vertical_stress_Pa(silo.straight_m))
        girths = 2 if silo.section == "round" else 1  # metres of girth that forces are counted for
        for state in ("filling", "discharge"):
            try:
                hopper = hopper_of(scene, angle_deg, pressure_ratio, above, state)
            except ValueError as error:  # a very rough wall is beyond Walker's theory
                found["walker_limit"] = str(error)
                break
            found[f"walker_{state}"] = {
                "transition_normal_Pa": float(hopper.transition_normal_stress_Pa),
                "wall_force_N_per_m": float(girths * hopper.wall_force_N_per_m),
                "outlet_force_N_per_m": float(girths * hopper.outlet_force_N_per_m),
            }
    if silo.has_opening:
        grain, density = scene.sand.d50_m, scene.density_kg_per_m3
        widths = [one.width for one in silo.openings if one.in_floor]  # of all that are open at a time
        if silo.section == "round":
            rate = beverloo.orifice_rate_kg_per_s(widths[0], density, grain, gravity_m_per_s2=g)
            rate = rate / (2.0 * math.pi) * 2.0 / (0.5 * silo.width_m)  # as forces are counted: of two metres of girth
        else:
            rate = sum(beverloo.slot_rate_kg_per_s_m(width, density, grain, gravity_m_per_s2=g) for width in widths)
        if widths:
            found["beverloo_kg_per_s_m"] = float(rate)
    return found
