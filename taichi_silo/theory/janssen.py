"""Janssen's theory of a plane silo: the stresses of a fill that hangs on two parallel walls by friction.

A horizontal slice of width b at depth z below the free surface is in vertical equilibrium when

    d(sigma_v)/dz = gamma - 2 mu K sigma_v / b,   sigma_v(0) = 0,

with the wall friction coefficient mu = tan(phi_w), fully mobilised, and the pressure ratio
K = sigma_h / sigma_v, constant over the depth. With the depth scale z0 = b / (2 K mu) the solution is

    sigma_v = gamma z0 (1 - exp(-z / z0)),   sigma_h = K sigma_v,   tau_w = mu sigma_h.

All stresses and forces are positive in compression, the wall shear where the wall carries weight.
Source: H. A. Janssen (1895); the same formulas are in EN 1991-4, section 5, with A/U = b/2 for a plane silo.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq


def _mean_decay(x):
    """Return (1 - exp(-x)) / x, which tends to 1 as x tends to 0."""
    x = np.asarray(x, dtype=float)
    safe = np.where(x == 0.0, 1.0, x)
    return np.where(x == 0.0, 1.0, -np.expm1(-safe) / safe)


def _mean_growth(x):
    """Return (x - 1 + exp(-x)) / x^2, which tends to 1/2 as x tends to 0 (a series where digits cancel)."""
    if x < 1e-3:
        return 1 / 2 - x / 6 + x**2 / 24 - x**3 / 120
    return (x + np.expm1(-x)) / x**2


@dataclass(frozen=True)
class Janssen:
    """Fill of a plane silo between two equal vertical walls.

    Parameters
    ----------
    width_m : float
        Distance b of the walls [m].
    height_m : float
        Fill height h [m].
    weight_density_N_per_m3 : float
        gamma = rho_s g / (1 + e) [N/m3].
    wall_friction_angle_deg : float
        phi_w, with mu = tan(phi_w) [degrees]; zero is a frictionless wall.
    pressure_ratio : float
        K = horizontal over vertical stress [-].
    """

    width_m: float
    height_m: float
    weight_density_N_per_m3: float
    wall_friction_angle_deg: float
    pressure_ratio: float

    def __post_init__(self):
        for name in ("width_m", "height_m", "weight_density_N_per_m3", "pressure_ratio"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not 0.0 <= self.wall_friction_angle_deg < 90.0:
            raise ValueError(f"wall_friction_angle_deg must be in [0, 90): {self.wall_friction_angle_deg}")

    @property
    def wall_friction(self) -> float:
        """Wall friction coefficient mu = tan(phi_w) [-]."""
        return float(np.tan(np.radians(self.wall_friction_angle_deg)))

    @property
    def depth_scale_m(self) -> float:
        """Depth z0 = b / (2 K mu) over which friction takes up the weight [m]; infinite without friction."""
        resistance = 2.0 * self.pressure_ratio * self.wall_friction
        return self.width_m / resistance if resistance > 0.0 else float("inf")

    def vertical_stress_Pa(self, depth_m):
        """Mean vertical stress sigma_v at a depth (number or array) below the free surface [Pa]."""
        depth = np.asarray(depth_m, dtype=float)
        return self.weight_density_N_per_m3 * depth * _mean_decay(depth / self.depth_scale_m)

    def normal_stress_Pa(self, depth_m):
        """Wall normal stress K sigma_v at a depth (number or array) [Pa]."""
        return self.pressure_ratio * self.vertical_stress_Pa(depth_m)

    def shear_stress_Pa(self, depth_m):
        """Wall shear stress mu K sigma_v at a depth (number or array) [Pa]."""
        return self.wall_friction * self.normal_stress_Pa(depth_m)

    @property
    def weight_N_per_m(self) -> float:
        """Weight W = gamma b h of the fill [N per metre run]."""
        return self.weight_density_N_per_m3 * self.width_m * self.height_m

    @property
    def normal_force_N_per_m(self) -> float:
        """Normal force N on one wall, K gamma z0 (h - z0 (1 - exp(-h / z0))) [N per metre run]."""
        growth = _mean_growth(self.height_m / self.depth_scale_m)
        return float(self.pressure_ratio * self.weight_density_N_per_m3 * self.height_m**2 * growth)

    @property
    def shear_force_N_per_m(self) -> float:
        """Friction force T = mu N on one wall [N per metre run]."""
        return self.wall_friction * self.normal_force_N_per_m

    @property
    def bottom_force_N_per_m(self) -> float:
        """Bottom force P = b sigma_v(h) [N per metre run]; P + 2 T = W."""
        return float(self.width_m * self.vertical_stress_Pa(self.height_m))


def pressure_ratio_from_normal_force(
    normal_force_N_per_m: float,
    width_m: float,
    height_m: float,
    weight_density_N_per_m3: float,
    wall_friction_angle_deg: float,
) -> float:
    """Return the pressure ratio K with which Janssen's theory gives a measured normal force on one wall.

    With x = h / z0 the force is N = N_max (1 - (1 - exp(-x)) / x), which grows with K from 0 to
    N_max = W / (2 mu), where friction carries the whole weight. The bounds 1 - 1/x <= N / N_max <= x/2
    enclose x.

    Raises
    ------
    ValueError
        If the force is not between 0 and W / (2 mu), so that no K belongs to it.
    """
    force = float(normal_force_N_per_m)
    unit = Janssen(width_m, height_m, weight_density_N_per_m3, wall_friction_angle_deg, pressure_ratio=1.0)
    mu = unit.wall_friction
    largest = unit.weight_N_per_m / (2.0 * mu) if mu > 0.0 else float("inf")
    if not 0.0 < force < largest:
        raise ValueError(
            f"no pressure ratio gives a wall normal force of {force:.6g} N/m: it must lie between 0 and "
            f"W / (2 mu) = {largest:.6g} N/m"
        )
    fraction = force / largest
    if fraction < 1e-12:  # friction plays no part: N = K gamma h^2 / 2
        return 2.0 * force / (weight_density_N_per_m3 * height_m**2)
    low, high = 2.0 * fraction * (1.0 - 1e-9), (1.0 + 1e-9) / (1.0 - fraction)
    x = brentq(lambda x: x * _mean_growth(x) - fraction, low, high, xtol=1e-14 * low, rtol=1e-14)
    return float(x * width_m / (2.0 * mu * height_m))
