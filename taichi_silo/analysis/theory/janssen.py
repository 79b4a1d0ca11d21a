"""Janssen's theory of a silo: the stresses of a fill that hangs on vertical walls by friction.

A horizontal slice of area A and perimeter U at depth z below the free surface is in vertical equilibrium when

    d(sigma_v)/dz = gamma - mu K sigma_v U / A,   sigma_v(0) = 0,

with the wall friction coefficient mu = tan(phi_w), fully mobilised, and the pressure ratio
K = sigma_h / sigma_v, constant over the depth. With the depth scale z0 = (A / U) / (K mu) the solution is

    sigma_v = gamma z0 (1 - exp(-z / z0)),   sigma_h = K sigma_v,   tau_w = mu sigma_h.

A plane silo (two parallel walls at a distance b, no others) has A/U = b/2, a round one of diameter d has A/U = d/4.
Forces are those on a strip of wall one metre long: of a plane silo per metre run, of a round one per metre of
circumference, its weight and bottom force too. A metre run of a plane silo has two walls, so that P + 2 T = W; a
metre of circumference is one wall, so that P + T = W (times pi d: the whole silo).

All stresses and forces are positive in compression, the wall shear where the wall carries weight.
Source: H. A. Janssen (1895); the same formulas are in EN 1991-4, section 5.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import exprel

from taichi_silo.analysis.root import root

WALLS = {"plane": 2, "round": 1}  # that carry the weight named in N per m
PERIMETER = {"plane": 2.0, "round": 4.0}  # width over A/U


def _mean_growth(x: float) -> float:
    """Return (x - 1 + exp(-x)) / x^2, which tends to 1/2 as x tends to 0 (a series where digits cancel)."""
    if x < 1e-3:
        return 1 / 2 - x / 6 + x**2 / 24 - x**3 / 120
    return (x + np.expm1(-x)) / x**2


@dataclass(frozen=True)
class Janssen:
    """Fill of a silo between two equal vertical walls, or within a round one."""

    width_m: float  # distance b of the walls, or the diameter d
    height_m: float  # of the fill, h
    weight_density_N_per_m3: float  # gamma = rho_s g / (1 + e)
    wall_friction_angle_deg: float  # phi_w, with mu = tan(phi_w); zero is a frictionless wall
    pressure_ratio: float  # K = horizontal over vertical stress [-]
    section: str = "plane"  # or "round"

    def __post_init__(self) -> None:
        for name in ("width_m", "height_m", "weight_density_N_per_m3", "pressure_ratio"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not 0.0 <= self.wall_friction_angle_deg < 90.0:
            raise ValueError(f"wall_friction_angle_deg must be in [0, 90): {self.wall_friction_angle_deg}")
        if self.section not in WALLS:
            raise ValueError(f"section must be one of {', '.join(WALLS)}, got {self.section!r}")

    @property
    def wall_friction(self) -> float:
        """Wall friction coefficient mu = tan(phi_w) [-]."""
        return float(np.tan(np.radians(self.wall_friction_angle_deg)))

    @property
    def depth_scale_m(self) -> float:
        """Depth z0 = (A/U) / (K mu) over which friction takes up the weight [m]; infinite without friction."""
        resistance = PERIMETER[self.section] * self.pressure_ratio * self.wall_friction
        return self.width_m / resistance if resistance > 0.0 else float("inf")

    def vertical_stress_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Mean vertical stress sigma_v at a depth (number or array) below the free surface [Pa]."""
        depth = np.asarray(depth_m, dtype=float)
        # exprel(-x) is (1 - exp(-x)) / x
        return self.weight_density_N_per_m3 * depth * exprel(-depth / self.depth_scale_m)

    def normal_stress_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Wall normal stress K sigma_v at a depth (number or array) [Pa]."""
        return self.pressure_ratio * self.vertical_stress_Pa(depth_m)

    def shear_stress_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Wall shear stress mu K sigma_v at a depth (number or array) [Pa]."""
        return self.wall_friction * self.normal_stress_Pa(depth_m)

    @property
    def area_m2_per_m(self) -> float:
        """Area of the section: b per metre run of a plane silo, d/4 per metre of circumference of a round one [m]."""
        return self.width_m if self.section == "plane" else self.width_m / PERIMETER[self.section]

    @property
    def weight_N_per_m(self) -> float:
        """Weight W of the fill, gamma b h [N per metre run] or gamma d h / 4 [N per metre of circumference]."""
        return self.weight_density_N_per_m3 * self.area_m2_per_m * self.height_m

    @property
    def normal_force_N_per_m(self) -> float:
        """Normal force N on one wall, K gamma z0 (h - z0 (1 - exp(-h / z0))) [N per metre]."""
        growth = _mean_growth(self.height_m / self.depth_scale_m)
        return float(self.pressure_ratio * self.weight_density_N_per_m3 * self.height_m**2 * growth)

    @property
    def shear_force_N_per_m(self) -> float:
        """Friction force T = mu N on one wall [N per metre]."""
        return self.wall_friction * self.normal_force_N_per_m

    @property
    def bottom_force_N_per_m(self) -> float:
        """Bottom force P = sigma_v(h) b [N per metre run; P + 2 T = W] or d/4 [of circumference; P + T = W]."""
        return float(self.area_m2_per_m * self.vertical_stress_Pa(self.height_m))


def pressure_ratio_from_normal_force(
    normal_force_N_per_m: float,
    width_m: float,
    height_m: float,
    weight_density_N_per_m3: float,
    wall_friction_angle_deg: float,
    section: str = "plane",
) -> float:
    """Return the pressure ratio K with which Janssen's theory gives a measured normal force on one wall.

    With x = h / z0 the force is N = N_max (1 - (1 - exp(-x)) / x), which grows with K from 0 to
    N_max = W / (2 mu), or W / mu of a round silo, where friction carries the whole weight. The bounds
    1 - 1/x <= N / N_max <= x/2 enclose x.

    Raises ValueError if the force is not between 0 and N_max, so that no K belongs to it.
    """
    force = float(normal_force_N_per_m)
    unit = Janssen(width_m, height_m, weight_density_N_per_m3, wall_friction_angle_deg, 1.0, section)
    mu = unit.wall_friction
    largest = unit.weight_N_per_m / (WALLS[section] * mu) if mu > 0.0 else float("inf")
    if not 0.0 < force < largest:
        raise ValueError(
            f"no pressure ratio gives a wall normal force of {force:.6g} N/m: it must lie between 0 and "
            f"W / ({'2 ' * (WALLS[section] == 2)}mu) = {largest:.6g} N/m"
        )
    fraction = force / largest
    if fraction < 1e-12:  # friction plays no part: N = K gamma h^2 / 2
        return 2.0 * force / (weight_density_N_per_m3 * height_m**2)
    low, high = 2.0 * fraction * (1.0 - 1e-9), (1.0 + 1e-9) / (1.0 - fraction)
    x = root(lambda x: x * _mean_growth(x) - fraction, low, high)
    return float(x * width_m / (PERIMETER[section] * mu * height_m))
