"""Pressures of a flow channel at the wall of a round silo, whose outlet is far from the axis: EN 1991-4:2006, 5.2.4.

It is asked for where e_o > 0.25 d_c, in action assessment classes 2 and 3. A channel of radius r_c, G = r_c / r, whose
middle is e_c off the axis, touches the wall over +- theta_c; psi is the same angle seen from its own middle. In class 3
there are three of them, G = 0.25, 0.4, 0.6, with the lower mu of the wall and the upper phi_i (5.52) to (5.66):

    eta = mu / tan(phi_i),   e_c = r (eta (1 - G) + (1 - eta) sqrt(1 - G))
    cos(theta_c) = (r^2 + e_c^2 - r_c^2) / (2 r e_c),   sin(psi) = sin(theta_c) / G
    U_wc = 2 theta_c r,   U_sc = 2 r_c (pi - psi),   A_c = (pi - psi) r_c^2 + theta_c r^2 - r r_c sin(psi - theta_c)
    inside:             p_hce = gamma K z_oc (1 - exp(-z / z_oc)),   z_oc = A_c / (K (U_wc mu + U_sc tan(phi_i)))
    far from it:        p_hse = p_hf
    theta_c to 2 theta_c: p_hae = 2 p_hse - p_hce, and p_w = mu p_h everywhere

Near the surface of a squat or intermediate silo, whose static solid hardly touches the wall, p_hae would be below 0. 0
is left there, as no solid pulls at a wall (as far as could be confirmed the clauses do not say it).

In class 2 there is one, theta_c = 35 degrees, with nothing inside and 2 p_hf beside it; not confirmed in print. The
column in the channel is in vertical equilibrium with the friction on wall and static solid.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taichi_silo.analysis.theory.eurocode.solids import Values
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo

RADII = (0.25, 0.4, 0.6)  # G in class 3
CLASS_2_DEG = 35.0


@dataclass(frozen=True)
class FlowChannel:
    """A channel that touches the wall."""

    silo: EurocodeSilo
    radius_share: float | None  # G; None: that of class 2

    @property
    def clause(self) -> str:
        """Where it stands."""
        return "5.2.4.2" if self.radius_share is None else "5.2.4.3"

    @cached_property
    def _values(self) -> Values:
        return self.silo.values("hopper discharge")  # lower mu, upper K and phi_i

    @property
    def _inside(self) -> float:
        """Tangent of phi_i."""
        return math.tan(math.radians(self._values.internal_friction_angle_deg))

    @property
    def eccentricity_m(self) -> float:
        """Distance e_c of its middle from the silo's axis [m]."""
        assert self.radius_share is not None, "class 2 has no radius"
        eta, rest = self._values.wall_friction / self._inside, 1.0 - self.radius_share
        return 0.5 * self.silo.width_m * (eta * rest + (1.0 - eta) * math.sqrt(rest))

    @cached_property
    def contact_deg(self) -> float:
        """Half the angle theta_c over which it touches the wall."""
        if self.radius_share is None:
            return CLASS_2_DEG
        r = 0.5 * self.silo.width_m
        e, own = self.eccentricity_m, self.radius_share * r
        return math.degrees(math.acos((r**2 + e**2 - own**2) / (2.0 * r * e)))

    @property
    def geometry(self) -> tuple[float, float, float]:
        """Area A_c [m2], and the lengths U_wc of wall and U_sc of static solid around it [m]."""
        assert self.radius_share is not None, "class 2 has no radius"
        r, theta = 0.5 * self.silo.width_m, math.radians(self.contact_deg)
        own = self.radius_share * r
        psi = math.asin(min(1.0, math.sin(theta) / self.radius_share))
        if r * math.cos(theta) < self.eccentricity_m:  # the chord lies beyond the channel's middle
            psi = math.pi - psi
        area = (math.pi - psi) * own**2 + theta * r**2 - r * own * math.sin(psi - theta)
        return area, 2.0 * theta * r, 2.0 * own * (math.pi - psi)

    @cached_property
    def depth_scale_m(self) -> float:
        """Depth z_oc [m]."""
        area, wall, solid = self.geometry
        values = self._values
        return area / values.pressure_ratio / (wall * values.wall_friction + solid * self._inside)

    def normal_Pa(self, depth_m: ArrayLike, angle_deg: float, load: str = "wall pressure") -> NDArray:
        """Pressure on the wall [Pa] at an angle from the channel's middle; far from it that for a load."""
        static, off = self.silo.filling_normal_Pa(depth_m, load), abs((angle_deg + 180.0) % 360.0 - 180.0)
        if off > 2.0 * self.contact_deg:
            return static
        inside = self._flowing_Pa(depth_m)
        return inside if off <= self.contact_deg else np.maximum(2.0 * static - inside, 0.0)

    def _flowing_Pa(self, depth_m: ArrayLike) -> NDArray:
        z = np.asarray(depth_m, dtype=float)
        if self.radius_share is None:
            return 0.0 * z
        most = self.silo.solid.upper_weight_density_N_per_m3 * self._values.pressure_ratio * self.depth_scale_m
        return most * -np.expm1(-z / self.depth_scale_m)

    def shear_Pa(self, depth_m: ArrayLike, angle_deg: float, load: str = "wall friction") -> NDArray:
        """Friction mu p_h on the wall [Pa]; in the channel with its own lower mu."""
        off = abs((angle_deg + 180.0) % 360.0 - 180.0)
        own = off <= self.contact_deg
        mu = self._values.wall_friction if own else self.silo.values(load).wall_friction
        return mu * self.normal_Pa(depth_m, angle_deg, load)


def channels(silo: EurocodeSilo) -> list[FlowChannel]:
    """The channels that 5.2.4 asks for; none of a silo whose outlet is near the axis, or that is not round."""
    if silo.section != "round" or not silo.is_eccentric or silo.action_class == 1 or silo.slenderness == "retaining":
        return []
    return [FlowChannel(silo, share) for share in (RADII if silo.action_class == 3 else (None,))]
