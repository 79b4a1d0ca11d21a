"""Particulate solids after EN 1991-4:2006: the characteristic values that table 3.1 asks for.

A characteristic value is the mean times its conversion factor a (upper) or over it (lower), 4.2. Table 3.1 says which
one counts: for the largest pressure on a vertical wall the lower mu and the upper K, for the largest friction both
upper, for the largest load on a bottom both lower; in a hopper the lower mu of its wall, with the lower K and phi_i
after filling and the upper ones on discharge. Silos of action assessment class 1 may take means.

The note to table 3.1 caps mu at tan(phi_i). Here the lower phi_i caps it for all loads. For the load on a bottom the
table itself names the upper phi_i, with which the cap hardly ever counts; the lower one is on the safe side and is
what a worked example of a cement silo uses (z_o = 6.07 m; 5.83 m with the upper one), whose source is not confirmed.

A wall of category D4 (corrugated) has mu = (1 - a_w) tan(phi_i) + a_w mu_D2, annex D.2, where a_w is the share of wall
that the solid slides on, 0.2 of a sinusoidal sheet; not confirmed against the print.
"""

import math
from dataclasses import dataclass

TABLE_3_1 = {  # load: power of the conversion factors of mu, K, phi_i
    "wall pressure": (-1, 1, -1),
    "wall friction": (1, 1, -1),
    "bottom load": (-1, -1, 1),
    "hopper filling": (-1, -1, -1),
    "hopper discharge": (-1, 1, 1),
}
WALLS = ("D1", "D2", "D3", "D4")  # polished, smooth, rough, corrugated: table 4.1
SINUSOIDAL = 0.2  # a_w


@dataclass(frozen=True)
class Solid:
    """Stored solid: the columns of table E.1, mean values and conversion factors."""

    title: str
    lower_weight_density_N_per_m3: float  # gamma_l
    upper_weight_density_N_per_m3: float  # gamma_u, with which loads are computed
    angle_of_repose_deg: float  # phi_r
    internal_friction_angle_deg: float  # phi_im
    internal_friction_factor: float  # a_phi
    pressure_ratio: float  # K_m
    pressure_ratio_factor: float  # a_K
    wall_friction_D1: float  # mu_m of a polished wall
    wall_friction_D2: float  # of a smooth one
    wall_friction_D3: float  # of a rough one
    wall_friction_factor: float  # a_mu
    patch_factor: float  # C_op

    def mean_friction(self, wall: str, contact: float = SINUSOIDAL) -> float:
        """Mean mu of a wall "D1" to "D4" [-]; `contact` is a_w of D4."""
        if wall != "D4":
            return float(getattr(self, f"wall_friction_{wall}"))
        inside = math.tan(math.radians(self.internal_friction_angle_deg))
        return (1.0 - contact) * inside + contact * self.wall_friction_D2

    def characteristic(self, load: str, wall: str, action_class: int = 2, contact: float = SINUSOIDAL) -> "Values":
        """The mu, K, phi_i that give the extreme of a load of TABLE_3_1; means in action assessment class 1."""
        powers = TABLE_3_1[load]
        mu, ratio, angle = (0 if action_class == 1 else power for power in powers)
        lowest = self.internal_friction_angle_deg / (1.0 if action_class == 1 else self.internal_friction_factor)
        friction = self.mean_friction(wall, contact) * self.wall_friction_factor**mu
        return Values(
            min(friction, math.tan(math.radians(lowest))),
            self.pressure_ratio * self.pressure_ratio_factor**ratio,
            self.internal_friction_angle_deg * self.internal_friction_factor**angle,
        )


@dataclass(frozen=True)
class Values:
    """Characteristic values for one load."""

    wall_friction: float  # mu [-]
    pressure_ratio: float  # K [-]
    internal_friction_angle_deg: float  # phi_i
