"""Walker's theory of a hopper: the stresses of a fill between walls that converge to an outlet.

x is the height above the apex, where the walls would meet, beta their angle to the vertical, h_h the height of the
transition to the vertical walls. On the wall p_n = F sigma_v and p_t = mu p_n, F constant over the height and the
friction mobilised. A slice dx has an area A ~ x^S, with S = 1 for a wedge of infinite length and S = 2 for a cone; per
dx of height the walls carry (tan(beta) + mu) p_n on every metre of perimeter U, where A/U = x tan(beta) / S. So

    d(A sigma_v)/dx + gamma A = F (tan(beta) + mu) U sigma_v,   and divided by A / x

    x d(sigma_v)/dx = n sigma_v - gamma x,   n = S (F + F mu cot(beta)) - S.

With sigma_vt at the transition and y = x / h_h the solution is

    sigma_v = gamma h_h (y - y^n) / (n - 1) + sigma_vt y^n,   for n = 1: (sigma_vt - gamma h_h ln(y)) y.

F on filling is 1 - b / (1 + tan(beta) / mu), b = 0.2, so that n = S (1 - b) mu cot(beta). On discharge the fill yields
passively, with phi_i, and slides on the wall: its circle of stress, of centre s, has p_n = s (1 + sin(phi_i) cos(eps)),
p_t = s sin(phi_i) sin(eps), and on the horizontal plane s (1 - sin(phi_i) cos(2 beta + eps)), so that

    F = (1 + sin(phi_i) cos(eps)) / (1 - sin(phi_i) cos(2 beta + eps)),   eps = phi_w + asin(sin(phi_w) / sin(phi_i)).

Both need mobilised friction: the hopper is steep when tan(beta) < (1 - K) / (2 mu). In a shallow one mu is replaced by
(1 - K) / (2 tan(beta)), and discharge is taken like filling.

Stresses and forces are positive in compression; forces per metre as in `janssen`: per metre run of a wedge, per metre
of circumference of the transition of a cone.
Source: D. M. Walker, Chem. Eng. Sci. 21 (1966) 975-997; EN 1991-4:2006, section 6: steep by (6.1), sigma_v and n by
6.1.2, filling by 6.3.2 with n by (6.28), discharge by 6.3.3; for a shallow hopper the clause is not confirmed. For n
EN prints S (F mu cot(beta) + F) - 2 as far as could be confirmed, which is in equilibrium for a cone only, and for a
wedge disagrees with its own (6.28); here the last term is S.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import exprel

ORDER = {"plane": 1, "round": 2}  # S
EMPIRICAL_B = 0.2


def filling_factor(half_angle_deg: float, wall_friction: float) -> float:
    """F = p_n / sigma_v after filling: 1 - b / (1 + tan(beta) / mu), b = 0.2; 1 without friction."""
    return 1.0 - EMPIRICAL_B * wall_friction / (wall_friction + np.tan(np.radians(half_angle_deg)))


def discharge_factor(half_angle_deg: float, wall_friction: float, internal_friction_angle_deg: float) -> float:
    """F = p_n / sigma_v on discharge, of a passive state that slides on the wall; phi_w counts up to phi_i.

    Raises ValueError if phi_i is not in (0, 90), or no passive state belongs to so wide a hopper: 2 beta + eps must be
    under 180.
    """
    if not 0.0 < internal_friction_angle_deg < 90.0:
        raise ValueError(f"internal_friction_angle_deg must be in (0, 90), got {internal_friction_angle_deg}")
    beta, phi = np.radians(half_angle_deg), np.radians(internal_friction_angle_deg)
    phi_w = min(np.arctan(wall_friction), phi)
    eps = phi_w + np.arcsin(min(np.sin(phi_w) / np.sin(phi), 1.0))
    if not 2.0 * beta + eps < np.pi:
        widest = np.degrees(0.5 * (np.pi - eps))
        raise ValueError(f"half_angle_deg must be under {widest:.4g} with this friction, got {half_angle_deg}")
    return float((1.0 + np.sin(phi) * np.cos(eps)) / (1.0 - np.sin(phi) * np.cos(2.0 * beta + eps)))


@dataclass(frozen=True)
class WalkerHopper:
    """Fill of a hopper below a transition with a given vertical stress."""

    width_m: float  # distance of the walls, or the diameter, at the transition
    outlet_m: float  # the same at the outlet
    half_angle_deg: float  # beta, of the wall to the vertical, in (0, 90)
    weight_density_N_per_m3: float  # gamma
    wall_friction_angle_deg: float  # phi_w of the hopper's wall, in [0, 90)
    transition_stress_Pa: float  # vertical stress sigma_vt at the transition, 0 or more
    state: str | float = "filling"  # or "discharge", or F itself, positive
    section: str = "plane"  # or "round"
    internal_friction_angle_deg: float | None = None  # phi_i, needed for "discharge"
    pressure_ratio: float | None = None  # K in (0, 1), which tells a shallow hopper; without it friction is mobilised

    def __post_init__(self) -> None:
        angle = "wall_friction_angle_deg"
        below = {"outlet_m": self.width_m, "half_angle_deg": 90.0, angle: 90.0, "pressure_ratio": 1.0}
        for name in ("width_m", "weight_density_N_per_m3", "transition_stress_Pa", *below):
            value, high = getattr(self, name), below.get(name, np.inf)
            may_be_0 = name in (angle, "transition_stress_Pa")
            if value is not None and not (0.0 < value < high or (value == 0.0 and may_be_0)):
                raise ValueError(f"{name} must be positive{' or 0' * may_be_0} and below {high:g}, got {value}")
        if self.section not in ORDER:
            raise ValueError(f"section must be one of {', '.join(ORDER)}, got {self.section!r}")
        if isinstance(self.state, str):
            if self.state not in ("filling", "discharge"):
                raise ValueError(f"state must be filling, discharge or a number, got {self.state!r}")
            if self.state == "discharge" and self.internal_friction_angle_deg is None:
                raise ValueError("internal_friction_angle_deg is needed for discharge, in (0, 90), got None")
            _ = self.factor  # may refuse the angles
        elif not 0.0 < self.state < np.inf:
            raise ValueError(f"state must be a positive number F, got {self.state}")

    @property
    def is_steep(self) -> bool:
        """Whether the wall's friction is mobilised: tan(beta) < (1 - K) / (2 mu)."""
        if self.pressure_ratio is None:
            return True
        mu = np.tan(np.radians(self.wall_friction_angle_deg))
        return bool(2.0 * mu * np.tan(np.radians(self.half_angle_deg)) < 1.0 - self.pressure_ratio)

    @property
    def wall_friction(self) -> float:
        """Mobilised wall friction mu [-]: tan(phi_w), or (1 - K) / (2 tan(beta)) in a shallow hopper."""
        if self.is_steep or self.pressure_ratio is None:
            return float(np.tan(np.radians(self.wall_friction_angle_deg)))
        return float((1.0 - self.pressure_ratio) / (2.0 * np.tan(np.radians(self.half_angle_deg))))

    @property
    def factor(self) -> float:
        """F = p_n / sigma_v [-]."""
        if not isinstance(self.state, str):
            return float(self.state)
        if self.state == "filling" or not self.is_steep or self.internal_friction_angle_deg is None:
            return float(filling_factor(self.half_angle_deg, self.wall_friction))
        return discharge_factor(self.half_angle_deg, self.wall_friction, self.internal_friction_angle_deg)

    @property
    def exponent(self) -> float:
        """Exponent n = S (F + F mu cot(beta)) - S [-]."""
        cot = 1.0 / np.tan(np.radians(self.half_angle_deg))
        return float(ORDER[self.section] * (self.factor * (1.0 + self.wall_friction * cot) - 1.0))

    @property
    def transition_height_m(self) -> float:
        """Height h_h of the transition above the apex [m]."""
        return float(0.5 * self.width_m / np.tan(np.radians(self.half_angle_deg)))

    @property
    def outlet_height_m(self) -> float:
        """Height x of the outlet above the apex [m]."""
        return float(0.5 * self.outlet_m / np.tan(np.radians(self.half_angle_deg)))

    def vertical_stress_Pa(self, height_m: ArrayLike) -> NDArray:
        """Mean vertical stress sigma_v at a height (number or array) above the apex [Pa]."""
        x, top = np.asarray(height_m, dtype=float), self.transition_height_m
        slack = 1e-9 * top
        if np.any(~((x >= self.outlet_height_m - slack) & (x <= top + slack))):
            raise ValueError(
                f"height_m above the apex must be in [{self.outlet_height_m:.6g}, {top:.6g}], got {height_m!r}"
            )
        y = x / top
        power = (self.exponent - 1.0) * np.log(y)
        own = -self.weight_density_N_per_m3 * x * np.log(y) * exprel(power)  # (y^(n-1) - 1) / ((n-1) ln(y))
        return own + self.transition_stress_Pa * y * np.exp(power)

    def normal_stress_Pa(self, height_m: ArrayLike) -> NDArray:
        """Pressure p_n = F sigma_v normal to the inclined wall [Pa]."""
        return self.factor * self.vertical_stress_Pa(height_m)

    def shear_stress_Pa(self, height_m: ArrayLike) -> NDArray:
        """Friction p_t = mu p_n along the inclined wall [Pa]."""
        return self.wall_friction * self.normal_stress_Pa(height_m)

    @property
    def transition_normal_stress_Pa(self) -> float:
        """Peak F sigma_vt of the wall pressure at the transition, against K sigma_vt on the wall above [Pa]."""
        return self.factor * self.transition_stress_Pa

    def _area_m2_per_m(self, height_m: float) -> float:
        """Area of the section at a height, per metre as forces are."""
        whole = self.width_m if self.section == "plane" else 0.25 * self.width_m
        return whole * (height_m / self.transition_height_m) ** ORDER[self.section]

    @property
    def weight_N_per_m(self) -> float:
        """Weight W of the fill between outlet and transition [N per metre, see the module]."""
        top, bottom = self.transition_height_m, self.outlet_height_m
        moments = self._area_m2_per_m(top) * top - self._area_m2_per_m(bottom) * bottom
        return float(self.weight_density_N_per_m3 * moments / (ORDER[self.section] + 1))

    @property
    def top_force_N_per_m(self) -> float:
        """Force of the fill above on the transition [N per metre]."""
        return float(self._area_m2_per_m(self.transition_height_m) * self.transition_stress_Pa)

    @property
    def outlet_force_N_per_m(self) -> float:
        """Force on the outlet [N per metre]."""
        return float(self._area_m2_per_m(self.outlet_height_m) * self.vertical_stress_Pa(self.outlet_height_m))

    @property
    def wall_force_N_per_m(self) -> float:
        """Vertical force V on one wall [N per metre]: top + W = outlet + 2 V of a wedge, outlet + V of a cone."""
        walls = 2.0 if self.section == "plane" else 1.0
        return (self.top_force_N_per_m + self.weight_N_per_m - self.outlet_force_N_per_m) / walls
