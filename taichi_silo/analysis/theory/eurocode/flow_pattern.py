"""Mass or funnel flow of a hopper, as EN 1991-4:2006 tells by a chart (3.3, figure 3.1).

The chart has no formula. Here the limits are those of radial flow after Jenike, from which such charts are drawn: the
largest half angle of mass flow, with the wall friction angle phi_w and delta, the effective angle of internal friction,
for which phi_i stands (a solid without cohesion),

    cone:   90 - acos((1 - sin(delta)) / (2 sin(delta))) / 2 - (phi_w + asin(sin(phi_w) / sin(delta))) / 2
    wedge:  (60.5 + atan((50 - delta) / 7.73) / 15.07) (1 - phi_w / (42.3 + 0.131 exp(0.06 delta)))

in degrees. It is an approximation of the chart: a hopper is said to have mass or funnel flow when all characteristic
values agree, and either may happen in between, for which the standard asks to look at both.
Source: A. W. Jenike, Bull. 123, Utah Eng. Exp. Station (1964); P. C. Arnold and A. G. McLean, Powder Technol. 13 (1976)
255-261 for the cone; L. ter Borg (1986) for the wedge. The formulas were not compared with the printed sources.
"""

import math
from itertools import product

from taichi_silo.analysis.theory.eurocode.bottoms import Bottom


def largest_half_angle_deg(section: str, wall_friction: float, internal_friction_angle_deg: float) -> float:
    """Half angle up to which a cone ("round") or a wedge ("plane") has mass flow; not below 0."""
    delta = internal_friction_angle_deg
    wall = min(math.degrees(math.atan(wall_friction)), delta)
    if section == "plane":
        wide = 60.5 + math.degrees(math.atan((50.0 - delta) / 7.73)) / 15.07
        return max(0.0, wide * (1.0 - wall / (42.3 + 0.131 * math.exp(0.06 * delta))))
    inside, sliding = math.sin(math.radians(delta)), math.sin(math.radians(wall))
    widest = 90.0 - 0.5 * math.degrees(math.acos(min(1.0, (1.0 - inside) / (2.0 * inside))))
    return max(0.0, widest - 0.5 * (wall + math.degrees(math.asin(min(1.0, sliding / inside)))))


def flow_pattern(bottom: Bottom) -> str:
    """Say what flow a bottom has: "mass flow", "funnel flow" or "mass or funnel flow"."""
    if bottom.kind == "flat" or bottom.half_angle_deg is None:
        return "funnel flow"
    solid, silo = bottom.silo.solid, bottom.silo
    mean, a_mu, a_phi = solid.mean_friction(bottom.wall, silo.wall_contact), solid.wall_friction_factor, (
        solid.internal_friction_factor
    )  # fmt: skip
    angles = (solid.internal_friction_angle_deg / a_phi, solid.internal_friction_angle_deg * a_phi)
    limits = [
        largest_half_angle_deg(silo.section, mu, angle) for mu, angle in product((mean / a_mu, mean * a_mu), angles)
    ]
    if bottom.half_angle_deg <= min(limits):
        return "mass flow"
    return "funnel flow" if bottom.half_angle_deg > max(limits) else "mass or funnel flow"
