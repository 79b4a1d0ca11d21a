"""Pressures on the vertical walls of a silo after EN 1991-4:2006.

z is the depth below the equivalent (levelled) surface, h_c the height from it to the transition, d_c the characteristic
inside dimension. 5.1(2) tells slender (2 <= h_c/d_c), intermediate (1 < h_c/d_c < 2), squat (0.4 < h_c/d_c <= 1) and
retaining silos (h_c/d_c <= 0.4 with a flat bottom; no pressures here). With z0 = (A/U) / (K mu), p_ho = gamma K z0:

    slender (5.2.1.1):       p_hf = p_ho (1 - exp(-z / z0)),   p_vf = p_hf / K
    others (5.3):            p_hf = p_ho Y_R,   Y_R = 1 - ((z - h0) / (z0 - h0) + 1)^n,
                             n = -(1 + tan(phi_r)) (1 - h0 / z0),   z0 by (5.75)
                             p_vf = gamma (h0 - ((z0 - h0) - (z + z0 - 2 h0)^(n+1) / (z0 - h0)^n) / (n + 1))
                             h0 = d_c tan(phi_r) / 6 of a round silo (5.78), d_c tan(phi_r) / 4 of a rectangular one

and p_wf = mu p_hf; above h0 a wall has no contact. Both are in vertical equilibrium with the friction. On discharge
p_he = C_h p_hf and p_we = C_w p_wf (5.2.2.1), in action assessment classes 2 and 3

    slender:                              C_h = 1.15,             C_w = 1.10
    intermediate, C_S = h_c/d_c - 1:      C_h = 1 + 0.15 C_S,     C_w = 1 + 0.1 C_S
    squat:                                1

A characteristic value of the stored solid is its mean times or divided by a conversion factor; which of the two counts
for a load is said by table 3.1, and the wall's friction never exceeds tan(phi_i). The solid is the sand of table E.1.

Not here: class 1, patch loads (5.2.1.2, 5.2.2.2), outlets far from the axis (5.2.4); hoppers are in `walker`. The
standard's scope has no silo of two parallel walls only: "plane" is the limit of a long rectangle. Not confirmed against
the text: the numbers of the subclauses of 5.3.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import exprel

TABLE_3_1 = {  # load: power of the conversion factors of mu, K, phi_i
    "wall pressure": (-1, 1, -1),
    "wall friction": (1, 1, -1),
    "bottom load": (-1, -1, 1),
}
CRITICAL_ECCENTRICITY = 0.25  # of an outlet, over d_c: beyond it 5.2.4 asks for more


@dataclass(frozen=True)
class Solid:
    """Stored solid: mean values and conversion factors."""

    lower_weight_density_N_per_m3: float  # gamma_l
    upper_weight_density_N_per_m3: float  # gamma_u, with which loads are computed
    angle_of_repose_deg: float  # phi_r
    internal_friction_angle_deg: float  # phi_i
    internal_friction_factor: float  # a_phi
    pressure_ratio: float  # K_m
    pressure_ratio_factor: float  # a_K
    wall_frictions: dict[str, float]  # mu of a polished (D1), smooth (D2) and rough (D3) wall
    wall_friction_factor: float  # a_mu

    def extremes(self, load: str, wall: str) -> tuple[float, float]:
        """Characteristic mu and K [-] that give the extreme of a load of TABLE_3_1 on a wall "D1", "D2" or "D3"."""
        friction, pressure, internal = TABLE_3_1[load]
        mu = self.wall_frictions[wall] * self.wall_friction_factor**friction
        angle = self.internal_friction_angle_deg * self.internal_friction_factor**internal
        return float(min(mu, np.tan(np.radians(angle)))), self.pressure_ratio * self.pressure_ratio_factor**pressure


SAND = Solid(14e3, 16e3, 39.0, 36.0, 1.09, 0.45, 1.11, {"D1": 0.38, "D2": 0.48, "D3": 0.57}, 1.16)  # table E.1


@dataclass(frozen=True)
class EurocodeSilo:
    """Silo with vertical walls and a flat bottom or a hopper, filled with sand."""

    width_m: float  # d_c, the diameter or the distance of two parallel walls
    height_m: float  # h_c, from the equivalent surface to the transition
    wall: str = "D2"  # category "D1", "D2" or "D3"
    section: str = "round"  # or "plane"
    outlet_eccentricity_m: float = 0.0  # distance e_o of the outlet's middle from the axis
    solid: Solid = SAND

    def limits(self) -> list[str]:
        """Return a sentence for each limit of the standard's validity that the silo is outside of (1.1.2)."""
        found = [
            f"{what} is {value:.4g}: it must be less than {limit:g}."
            for value, limit, what in (
                (self.height_m / self.width_m, 10.0, "The ratio h_b/d_c of height and width"),
                (self.height_m, 100.0, "The height h_b [m]"),
                (self.width_m, 60.0, "The width d_c [m]"),
            )
            if value >= limit
        ]
        if self.section == "plane":
            found.append("Two parallel walls are the limit of a long rectangle, which the standard does not name.")
        if self.outlet_eccentricity_m > CRITICAL_ECCENTRICITY * self.width_m:
            found.append("The outlet is more than 0.25 d_c off the axis: the pressures of 5.2.4 come on top.")
        return found

    @property
    def slenderness(self) -> str:
        """Class by h_c/d_c: "slender", "intermediate", "squat" or "retaining"."""
        ratio = self.height_m / self.width_m
        if ratio >= 2.0:
            return "slender"
        return "intermediate" if ratio > 1.0 else "squat" if ratio > 0.4 else "retaining"

    @property
    def hydraulic_radius_m(self) -> float:
        """A/U: d/4 of a round silo, b/2 of a plane one [m]."""
        return self.width_m / (4.0 if self.section == "round" else 2.0)

    @property
    def surface_depth_m(self) -> float:
        """Depth h0 of the highest contact of fill and wall [m]; 0 of a slender silo, whose heap is not looked at."""
        if self.slenderness == "slender":
            return 0.0
        share = 6.0 if self.section == "round" else 4.0
        return float(self.width_m * np.tan(np.radians(self.solid.angle_of_repose_deg)) / share)

    def depth_scale_m(self, load: str = "wall pressure") -> float:
        """Depth z0 = (A/U) / (K mu) [m]."""
        mu, ratio = self.solid.extremes(load, self.wall)
        return self.hydraulic_radius_m / (ratio * mu)

    def _fill(self, depth_m: ArrayLike, load: str) -> tuple[NDArray, float, float, float, NDArray]:
        """Depth z, z0, h0, n and w = (z - h0) / (z0 - h0) + 1 (1 above h0) of the formulas of 5.3."""
        z = np.asarray(depth_m, dtype=float)
        if np.any(~((z >= 0.0) & (z <= self.height_m * (1.0 + 1e-9)))):
            raise ValueError(f"depth_m must be in [0, {self.height_m}], got {depth_m!r}")
        if self.slenderness == "retaining":
            raise ValueError(f"h_c/d_c must be above 0.4, got {self.height_m / self.width_m:.4g}: a retaining silo")
        z0, h0 = self.depth_scale_m(load), self.surface_depth_m
        n = -(1.0 + np.tan(np.radians(self.solid.angle_of_repose_deg))) * (1.0 - h0 / z0)
        return z, z0, h0, n, np.maximum(z - h0, 0.0) / (z0 - h0) + 1.0

    def filling_normal_Pa(self, depth_m: ArrayLike, load: str = "wall pressure") -> NDArray:
        """Pressure p_hf on the wall after filling [Pa]."""
        z, z0, _, n, w = self._fill(depth_m, load)
        share = -np.expm1(-z / z0) if self.slenderness == "slender" else -np.expm1(n * np.log(w))
        return self.solid.upper_weight_density_N_per_m3 * self.solid.extremes(load, self.wall)[1] * z0 * share

    def filling_shear_Pa(self, depth_m: ArrayLike, load: str = "wall friction") -> NDArray:
        """Friction p_wf = mu p_hf on the wall after filling [Pa]."""
        return self.solid.extremes(load, self.wall)[0] * self.filling_normal_Pa(depth_m, load)

    def filling_vertical_Pa(self, depth_m: ArrayLike, load: str = "bottom load") -> NDArray:
        """Vertical pressure p_vf in the fill [Pa]; above h0 the weight of the fill above."""
        z, z0, h0, n, w = self._fill(depth_m, load)
        if self.slenderness == "slender":
            return self.filling_normal_Pa(z, load) / self.solid.extremes(load, self.wall)[1]
        mean = exprel((n + 1.0) * np.log(w)) * np.log(w)  # (w^(n+1) - 1) / (n + 1)
        return self.solid.upper_weight_density_N_per_m3 * np.where(z < h0, z, h0 + (z0 - h0) * mean)

    @property
    def discharge_factors(self) -> tuple[float, float]:
        """C_h of the pressure and C_w of the friction [-]."""
        share = {"slender": 1.0, "intermediate": self.height_m / self.width_m - 1.0}.get(self.slenderness, 0.0)
        return 1.0 + 0.15 * share, 1.0 + 0.1 * share

    def discharge_normal_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Pressure p_he = C_h p_hf on the wall on discharge [Pa]."""
        return self.discharge_factors[0] * self.filling_normal_Pa(depth_m)

    def discharge_shear_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Friction p_we = C_w p_wf on the wall on discharge [Pa]."""
        return self.discharge_factors[1] * self.filling_shear_Pa(depth_m)
