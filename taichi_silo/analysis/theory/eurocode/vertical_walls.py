"""Symmetrical pressures on the vertical walls of a silo after EN 1991-4:2006.

z is the depth below the equivalent (levelled) surface, h_c the height from it to the transition, d_c the characteristic
inside dimension. 5.1 (2) tells slender (2 <= h_c/d_c), intermediate (1 < h_c/d_c < 2), squat (h_c/d_c <= 1) and
retaining silos (h_c/d_c <= 0.4 with a flat bottom). With z0 = (A/U) / (K mu) and p_ho = gamma K z0

    slender (5.2.1.1):       p_hf = p_ho (1 - exp(-z / z0)),   p_vf = p_hf / K                           (5.1) to (5.6)
    intermediate and squat:  p_hf = p_ho Y_R,   Y_R = 1 - ((z - h0) / (z0 - h0) + 1)^n
    (5.3.1)                  n = -(1 + tan(phi_r)) (1 - h0 / z0),   z0 by (5.75)
                             p_vf = gamma z_V,  z_V = h0 - (z0 - h0 - (z + z0 - 2 h0)^(n+1) / (z0 - h0)^n) / (n + 1)
                             h0 = d_c tan(phi_r) / 6 of a round silo (5.77), d_c tan(phi_r) / 4 of a rectangular one
    retaining (5.4):         p_hf = gamma K (1 + sin(phi_r)) (z - h0)

and p_wf = mu p_hf; above h0 a wall has no contact. The friction carried down to z, n_zSk = (A/U) (gamma z - p_vf) of
the first two, which are in vertical equilibrium, gamma mu K (1 + sin(phi_r)) (z - h0)^2 / 2 of the third. On discharge
p_he = C_h p_hf, p_we = C_w p_wf and C_w n_zSk (5.2.2.1, 5.3.2.1):

    class 2 and 3:  slender 1.15 and 1.10; intermediate, C_S = h_c/d_c - 1: 1 + 0.15 C_S and 1 + 0.1 C_S; others 1
    class 1:        slender 1.15 + 1.5 (1 + 0.4 e/d_c) C_op and 1.4 (1 + 0.4 e/d_c), e the larger of e_f and e_o;
                    intermediate 1 plus C_S times what these are above 1
    unloaded from the top: 1

Which characteristic values count for a load is said by `solids`. The standard's scope has no silo of two parallel walls
only: "plane" without a length is the limit of a long rectangle. Not confirmed against the print: class 1, 5.4, and the
numbers of the subclauses of 5.3.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import exprel

from taichi_silo.analysis.theory.eurocode.solids import SINUSOIDAL, Solid, Values

CRITICAL_ECCENTRICITY = 0.25  # of an outlet, over d_c: beyond it 5.2.4 asks for more
RETAINING, SQUAT, SLENDER = 0.4, 1.0, 2.0  # limits of h_c/d_c


@dataclass(frozen=True)
class EurocodeSilo:
    """The vertical walls of a silo, with the solid that it stores."""

    width_m: float  # d_c: the diameter, the shorter side, or the distance of two parallel walls
    height_m: float  # h_c, from the equivalent surface to the transition
    solid: Solid
    wall: str = "D2"  # category "D1", "D2", "D3" or "D4"
    section: str = "round"  # or "plane"
    outlet_eccentricity_m: float = 0.0  # distance e_o of the outlet's middle from the axis
    length_m: float | None = None  # longer side of a rectangular silo, section "plane"; None: parallel walls
    filling_eccentricity_m: float = 0.0  # largest distance e_f of the top of the heap from the axis
    action_class: int = 2  # action assessment class, 2.5
    wall_contact: float = SINUSOIDAL  # a_w of a wall D4
    hopper_height_m: float = 0.0  # h_h, from the transition down to the hopper's apex; 0 with a flat bottom
    from_top: bool = False  # unloaded from the top, without flow inside

    def __post_init__(self) -> None:
        deepest = self.surface_depth_m
        if self.slenderness != "slender" and not deepest < self.depth_scale_m("wall friction"):
            raise ValueError(
                f"h0 is {deepest:.4g} m with an angle of repose of {self.solid.angle_of_repose_deg:g} deg; it must be "
                f"below z0 = {self.depth_scale_m('wall friction'):.4g} m, a smaller K or wall friction is needed"
            )

    def limits(self) -> list[str]:
        """Return a sentence for each limit of the standard's validity that the silo is outside of (1.1.2)."""
        whole = self.height_m + self.hopper_height_m
        found = [
            f"{what} is {value:.4g}: it must be less than {limit:g}."
            for value, limit, what in (
                (whole / self.width_m, 10.0, "The ratio h_b/d_c of height and width"),
                (whole, 100.0, "The height h_b [m]"),
                (self.width_m, 60.0, "The width d_c [m]"),
            )
            if value >= limit
        ]
        if self.section == "plane" and self.length_m is None:
            found.append("Two parallel walls are the limit of a long rectangle, which the standard does not name.")
        if self.section == "plane" and self.is_eccentric:
            found.append("The outlet is more than 0.25 d_c off the axis: 5.2.4 has pressures for round silos only.")
        return found

    @property
    def slenderness(self) -> str:
        """Class by h_c/d_c: "slender", "intermediate", "squat" or "retaining"."""
        ratio = self.height_m / self.width_m
        if ratio >= SLENDER:
            return "slender"
        if ratio > SQUAT:
            return "intermediate"
        return "retaining" if ratio <= RETAINING and not self.hopper_height_m else "squat"

    @property
    def is_eccentric(self) -> bool:
        """Whether the outlet is so far off the axis that 5.2.4 asks for more."""
        return self.outlet_eccentricity_m > CRITICAL_ECCENTRICITY * self.width_m

    @property
    def hydraulic_radius_m(self) -> float:
        """A/U: d/4 of a round silo, b l / (2 (b + l)) of a rectangular one, b/2 between parallel walls [m]."""
        if self.section == "round":
            return self.width_m / 4.0
        return self.width_m / 2.0 / (1.0 + (0.0 if self.length_m is None else self.width_m / self.length_m))

    @property
    def surface_depth_m(self) -> float:
        """Depth h0 of the highest contact of fill and wall [m]; 0 of a slender silo, whose heap is not looked at."""
        if self.slenderness == "slender":
            return 0.0
        share = 6.0 if self.section == "round" else 4.0
        return float(self.width_m * np.tan(np.radians(self.solid.angle_of_repose_deg)) / share)

    def values(self, load: str) -> Values:
        """Characteristic mu, K and phi_i for a load of table 3.1."""
        return self.solid.characteristic(load, self.wall, self.action_class, self.wall_contact)

    def depth_scale_m(self, load: str = "wall pressure") -> float:
        """Depth z0 = (A/U) / (K mu) [m]; infinite without friction."""
        values = self.values(load)
        product = values.pressure_ratio * values.wall_friction
        return self.hydraulic_radius_m / product if product > 0.0 else float("inf")

    def _depth(self, depth_m: ArrayLike) -> NDArray:
        z = np.asarray(depth_m, dtype=float)
        if np.any(~((z >= 0.0) & (z <= self.height_m * (1.0 + 1e-9)))):
            raise ValueError(f"depth_m must be in [0, {self.height_m}], got {depth_m!r}")
        return z

    def _turns(self, z: NDArray, load: str) -> tuple[float, NDArray]:
        """Exponent n, and ln(w) with w = (z - h0) / (z0 - h0) + 1 (1 above h0), of the formulas of 5.3."""
        z0, h0 = self.depth_scale_m(load), self.surface_depth_m
        n = -(1.0 + np.tan(np.radians(self.solid.angle_of_repose_deg))) * (1.0 - h0 / z0)
        return float(n), np.log1p(np.maximum(z - h0, 0.0) / (z0 - h0))

    def filling_normal_Pa(self, depth_m: ArrayLike, load: str = "wall pressure") -> NDArray:
        """Pressure p_hf on the wall after filling [Pa], with the values for a load."""
        z, z0, ratio = self._depth(depth_m), self.depth_scale_m(load), self.values(load).pressure_ratio
        most = self.solid.upper_weight_density_N_per_m3 * ratio
        if self.slenderness == "slender":
            return most * z * exprel(-z / z0)  # exprel(-x) is (1 - exp(-x)) / x
        if self.slenderness == "retaining":
            return most * self._passing * np.maximum(z - self.surface_depth_m, 0.0)
        n, turns = self._turns(z, load)
        return most * z0 * -np.expm1(n * turns)

    @property
    def _passing(self) -> float:
        """1 + sin(phi_r)."""
        return float(1.0 + np.sin(np.radians(self.solid.angle_of_repose_deg)))

    def filling_shear_Pa(self, depth_m: ArrayLike, load: str = "wall friction") -> NDArray:
        """Friction p_wf = mu p_hf on the wall after filling [Pa]."""
        return self.values(load).wall_friction * self.filling_normal_Pa(depth_m, load)

    def filling_vertical_Pa(self, depth_m: ArrayLike, load: str = "bottom load") -> NDArray:
        """Vertical pressure p_vf in the fill [Pa]; above h0, and in a retaining silo, the weight of the fill above."""
        z, density = self._depth(depth_m), self.solid.upper_weight_density_N_per_m3
        if self.slenderness == "slender":
            return self.filling_normal_Pa(z, load) / self.values(load).pressure_ratio
        if self.slenderness == "retaining":
            return density * z
        n, turns = self._turns(z, load)
        z0, h0 = self.depth_scale_m(load), self.surface_depth_m
        mean = exprel((n + 1.0) * turns) * turns  # (w^(n+1) - 1) / (n + 1)
        return density * np.where(z < h0, z, h0 + (z0 - h0) * mean)

    def filling_wall_force_N_per_m(self, depth_m: ArrayLike, load: str = "wall friction") -> NDArray:
        """Vertical compression n_zSk of the wall after filling [N per metre of girth]: the friction above a depth."""
        z, density = self._depth(depth_m), self.solid.upper_weight_density_N_per_m3
        if self.slenderness != "retaining":
            return self.hydraulic_radius_m * (density * z - self.filling_vertical_Pa(z, load))
        values, below = self.values(load), np.maximum(z - self.surface_depth_m, 0.0)
        return 0.5 * density * values.wall_friction * values.pressure_ratio * self._passing * below**2

    @property
    def discharge_factors(self) -> tuple[float, float]:
        """C_h of the pressure and C_w of the friction [-]."""
        share = {"slender": 1.0, "intermediate": self.height_m / self.width_m - 1.0}.get(self.slenderness, 0.0)
        if self.from_top:
            return 1.0, 1.0
        if self.action_class > 1:
            return 1.0 + 0.15 * share, 1.0 + 0.1 * share
        off = 1.0 + 0.4 * max(self.filling_eccentricity_m, self.outlet_eccentricity_m) / self.width_m
        return 1.0 + share * (0.15 + 1.5 * off * self.solid.patch_factor), 1.0 + share * (1.4 * off - 1.0)

    def discharge_normal_Pa(self, depth_m: ArrayLike, load: str = "wall pressure") -> NDArray:
        """Pressure p_he = C_h p_hf on the wall on discharge [Pa]."""
        return self.discharge_factors[0] * self.filling_normal_Pa(depth_m, load)

    def discharge_shear_Pa(self, depth_m: ArrayLike, load: str = "wall friction") -> NDArray:
        """Friction p_we = C_w p_wf on the wall on discharge [Pa]."""
        return self.discharge_factors[1] * self.filling_shear_Pa(depth_m, load)

    def discharge_wall_force_N_per_m(self, depth_m: ArrayLike, load: str = "wall friction") -> NDArray:
        """Vertical compression C_w n_zSk of the wall on discharge [N per metre of girth]."""
        return self.discharge_factors[1] * self.filling_wall_force_N_per_m(depth_m, load)
