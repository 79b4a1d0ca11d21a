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
p_he = C_h p_hf and p_we = C_w p_wf (5.2.2.1); C_h = C_w = 1 when unloaded from the top. With e the larger eccentricity:

    slender, assessment class 2 or 3:   C_h = 1.15,   C_w = 1.10
    slender, class 1 (mean values):     C_h = 1.15 + 1.5 (1 + 0.4 e/d_c) C_op,   C_w = 1.4 (1 + 0.4 e/d_c)
    intermediate, C_S = h_c/d_c - 1:    C_h = 1 + 0.15 C_S, C_w = 1 + 0.1 C_S;   class 1: C_h = 1 + (0.15 + 1.5
                                        (1 + 0.4 e/d_c) C_op) C_S, C_w = 1 + 0.4 (1 + 1.4 e/d_c) C_S
    squat:                              1

A patch of height pi d_c / 16 may press more anywhere, by C_pf p_hf (5.2.1.2) or C_pe p_he (5.2.2.2); with E = 2 e/d_c

    C_pf = 0.21 C_op (1 + 2 E^2) (1 - exp(-1.5 (h_c/d_c - 1)))       e = e_f of the filling, never below 0
    C_pe = 0.42 C_op (1 + 2 E^2) (1 - exp(-1.5 (h_c/d_c - 1)))       h_c/d_c > 1.2
         = 0.272 C_op (h_c/d_c - 1 + E)                              otherwise, never below 0

Far eccentric outlets: `flow_channel`; hoppers: `walker`. The standard's scope has no silo of parallel walls only:
"plane" is the limit of a long rectangle. Numbers of clauses not confirmed: the subclauses of 5.3, the limit on the size
of grains. Class 1 factors and C_pf below slender are from memory; they are continuous with both neighbours.
"""

from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.theory.flow_channel import CRITICAL_ECCENTRICITY, FlowChannel
from taichi_silo.analysis.theory.solids import SAND, Solid, Values

__all__ = ["SAND", "EurocodeSilo", "Solid", "Values"]
SECTIONS = ("round", "rectangular", "plane")


@dataclass(frozen=True)
class EurocodeSilo:
    """Silo with vertical walls and a stored solid.

    Parameters
    ----------
    width_m : float
        d_c: the diameter, the shorter side, or the distance of two parallel walls [m].
    height_m : float
        h_c, from the equivalent surface to the transition [m].
    solid : Solid
        What is stored.
    wall : str
        Category "D1", "D2" or "D3".
    section : str
        "round", "rectangular" or "plane".
    length_m : float, optional
        The longer side of a rectangle [m].
    assessment_class : int
        1, 2 or 3; class 1 is computed with mean values.
    unloading : str
        "outlet" or "top".
    filling_eccentricity_m, outlet_eccentricity_m : float
        e_f and e_o [m].
    hopper_height_m : float
        h_h below the transition [m], for the limits of validity.
    grain_size_m : float
        Of the largest grains [m], for the limits of validity.
    """

    width_m: float
    height_m: float
    solid: Solid = SAND
    wall: str = "D2"
    section: str = "round"
    length_m: float | None = None
    assessment_class: int = 2
    unloading: str = "outlet"
    filling_eccentricity_m: float = 0.0
    outlet_eccentricity_m: float = 0.0
    hopper_height_m: float = 0.0
    grain_size_m: float = 0.0

    def __post_init__(self):
        for name in ("width_m", "height_m"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be positive and finite, got {getattr(self, name)}")
        for name in ("filling_eccentricity_m", "outlet_eccentricity_m"):
            if not 0.0 <= getattr(self, name) <= 0.5 * self.width_m:
                raise ValueError(f"{name} must be in [0, {0.5 * self.width_m}], got {getattr(self, name)}")
        for name in ("hopper_height_m", "grain_size_m"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be 0 or more, got {getattr(self, name)}")
        choices = {"section": SECTIONS, "assessment_class": (1, 2, 3), "unloading": ("outlet", "top")}
        for name, allowed in choices.items():
            if getattr(self, name) not in allowed:
                raise ValueError(f"{name} must be one of {', '.join(map(str, allowed))}, got {getattr(self, name)!r}")
        if (self.section == "rectangular") != (self.length_m is not None):
            raise ValueError(f"length_m belongs to a rectangular section, got {self.length_m} for {self.section}")
        if self.length_m is not None and not self.width_m <= self.length_m < np.inf:
            raise ValueError(f"length_m must be finite and not below width_m = {self.width_m}, got {self.length_m}")
        self.solid.extremes("mean", self.wall)

    def limits(self) -> list[str]:
        """Return a sentence for each limit of the standard's validity that the silo is outside of (1.1.2)."""
        total = self.height_m + self.hopper_height_m
        checks = [
            (total / self.width_m, 10.0, "The ratio h_b/d_c of height and width"),
            (total, 100.0, "The height h_b [m]"),
            (self.width_m, 60.0, "The width d_c [m]"),
            (self.grain_size_m / self.width_m, 0.03, "The ratio of the largest grains and the width"),
        ]
        found = [
            f"{what} is {value:.4g}: it must be less than {limit:g}." for value, limit, what in checks if value >= limit
        ]
        if self.section == "plane":
            found.append("Two parallel walls are the limit of a long rectangle, which the standard does not name.")
        if self.unloading == "outlet" and self.outlet_eccentricity_m > CRITICAL_ECCENTRICITY * self.width_m:
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
        """A/U: d/4, b/2, or a b / (2 (a + b)) [m]."""
        if self.section == "rectangular":
            return self.width_m * self.length_m / (2.0 * (self.width_m + self.length_m))
        return self.width_m / (4.0 if self.section == "round" else 2.0)

    @property
    def surface_depth_m(self) -> float:
        """Depth h0 of the highest contact of fill and wall [m]; 0 of a slender silo, whose heap is not looked at."""
        if self.slenderness == "slender":
            return 0.0
        share = 6.0 if self.section == "round" else 4.0
        return float(self.width_m * np.tan(np.radians(self.solid.angle_of_repose_deg)) / share)

    def values(self, load: str = "wall pressure") -> Values:
        """Characteristic values for a load; the mean ones in class 1."""
        self.solid.extremes(load, self.wall)
        return self.solid.extremes("mean" if self.assessment_class == 1 else load, self.wall)

    def depth_scale_m(self, load: str = "wall pressure") -> float:
        """Depth z0 = (A/U) / (K mu) [m]."""
        values = self.values(load)
        return self.hydraulic_radius_m / (values.pressure_ratio * values.wall_friction)

    def _fill(self, depth_m, load):
        """Depth, z0, h0, and n with w = (z - h0) / (z0 - h0) + 1 (1 above h0) of a silo that is not slender."""
        z = np.asarray(depth_m, dtype=float)
        if np.any(~((z >= 0.0) & (z <= self.height_m * (1.0 + 1e-9)))):
            raise ValueError(f"depth_m must be in [0, {self.height_m}], got {depth_m}")
        if self.slenderness == "retaining":
            raise ValueError(f"h_c/d_c must be above 0.4, got {self.height_m / self.width_m:.4g}: a retaining silo")
        z0, h0 = self.depth_scale_m(load), self.surface_depth_m
        if not h0 < z0:
            raise ValueError(f"h0 must be less than z0 = {z0:.4g} m, got {h0:.4g} m")
        n = -(1.0 + np.tan(np.radians(self.solid.angle_of_repose_deg))) * (1.0 - h0 / z0)
        return z, z0, h0, n, np.maximum(z - h0, 0.0) / (z0 - h0) + 1.0

    def filling_normal_Pa(self, depth_m, load: str = "wall pressure"):
        """Pressure p_hf on the wall after filling [Pa]."""
        z, z0, _, n, w = self._fill(depth_m, load)
        share = -np.expm1(-z / z0) if self.slenderness == "slender" else -np.expm1(n * np.log(w))
        return self.values(load).weight_density_N_per_m3 * self.values(load).pressure_ratio * z0 * share

    def filling_shear_Pa(self, depth_m, load: str = "wall friction"):
        """Friction p_wf = mu p_hf on the wall after filling [Pa]."""
        return self.values(load).wall_friction * self.filling_normal_Pa(depth_m, load)

    def filling_vertical_Pa(self, depth_m, load: str = "bottom load"):
        """Vertical pressure p_vf in the fill [Pa]; above h0 the weight of the fill above."""
        z, z0, h0, n, w = self._fill(depth_m, load)
        if self.slenderness == "slender":
            return self.filling_normal_Pa(z, load) / self.values(load).pressure_ratio
        log = (n + 1.0) * np.log(w)
        small = np.where(log == 0.0, 1.0, log)
        mean = np.where(log == 0.0, 1.0, np.expm1(small) / small) * np.log(w)  # (w^(n+1) - 1) / (n + 1)
        return self.values(load).weight_density_N_per_m3 * np.where(z < h0, z, h0 + (z0 - h0) * mean)

    @property
    def discharge_factors(self) -> tuple[float, float]:
        """C_h of the pressure and C_w of the friction [-]."""
        if self.unloading == "top" or self.slenderness in ("squat", "retaining"):
            return 1.0, 1.0
        share = 1.0 if self.slenderness == "slender" else self.height_m / self.width_m - 1.0  # 1 or C_S
        if self.assessment_class > 1:
            return 1.0 + 0.15 * share, 1.0 + 0.1 * share
        off = max(self.filling_eccentricity_m, self.outlet_eccentricity_m) / self.width_m
        extra = 0.15 + 1.5 * (1.0 + 0.4 * off) * self.solid.patch_factor
        return 1.0 + extra * share, 1.0 + 0.4 * (1.0 + 1.4 * off) * share

    def discharge_normal_Pa(self, depth_m, load: str = "wall pressure"):
        """Pressure p_he = C_h p_hf on the wall on discharge [Pa]."""
        return self.discharge_factors[0] * self.filling_normal_Pa(depth_m, load)

    def discharge_shear_Pa(self, depth_m, load: str = "wall friction"):
        """Friction p_we = C_w p_wf on the wall on discharge [Pa]."""
        return self.discharge_factors[1] * self.filling_shear_Pa(depth_m, load)

    @property
    def patch_height_m(self) -> float:
        """Height s = pi d_c / 16 of a patch [m]."""
        return float(np.pi * self.width_m / 16.0)

    @property
    def filling_patch_factor(self) -> float:
        """C_pf of a patch after filling, over p_hf [-]."""
        return 0.21 * self._patch(2.0 * self.filling_eccentricity_m / self.width_m)

    @property
    def discharge_patch_factor(self) -> float:
        """C_pe of a patch on discharge, over p_he [-]."""
        E = 2.0 * max(self.filling_eccentricity_m, self.outlet_eccentricity_m) / self.width_m
        ratio = self.height_m / self.width_m
        return 0.42 * self._patch(E) if ratio > 1.2 else max(0.272 * self.solid.patch_factor * (ratio - 1.0 + E), 0.0)

    def _patch(self, E: float) -> float:
        growth = -np.expm1(-1.5 * (self.height_m / self.width_m - 1.0))
        return float(self.solid.patch_factor * (1.0 + 2.0 * E**2) * max(growth, 0.0))

    def flow_channel(self, size_ratio: float) -> FlowChannel:
        """Return the channel of flow of an outlet far from the axis (5.2.4), of the given G = r_c / r.

        Raises
        ------
        ValueError
            Unless the silo is round, slender, of class 2 or 3, and its outlet more than 0.25 d_c off the axis.
        """
        off = self.outlet_eccentricity_m / self.width_m
        if self.section != "round" or self.slenderness != "slender" or self.assessment_class == 1:
            got = f"{self.section}, {self.slenderness}, class {self.assessment_class}"
            raise ValueError(f"section must be round, slender and of class 2 or 3, got {got}")
        if not off > CRITICAL_ECCENTRICITY:
            raise ValueError(f"outlet_eccentricity_m must be above {CRITICAL_ECCENTRICITY} d_c, got {off:.4g} d_c")
        v = self.values("eccentric discharge")
        rest = (v.weight_density_N_per_m3, v.wall_friction, v.pressure_ratio, v.internal_friction_angle_deg)
        return FlowChannel(0.5 * self.width_m, size_ratio, *rest)
