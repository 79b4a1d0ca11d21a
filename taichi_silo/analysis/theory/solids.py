"""Characteristic values of a stored solid after EN 1991-4:2006.

A value has a mean x_m and a conversion factor a_x: its upper characteristic value is x_m a_x, its lower x_m / a_x.
Which of them counts is said for each load in table 3.1. The wall's friction never exceeds tan(phi_i). Sand's values are
those of table E.1. Not confirmed against the text: the rows "hopper filling" and "hopper discharge" but for mu and K on
filling; and K of "eccentric discharge", whose lower mu and upper phi_i follow from a published example, which
`flow_channel` is tested with.
"""

from dataclasses import dataclass

import numpy as np

# load: values of mu, K, phi_i
TABLE_3_1 = {
    "mean": ("mean", "mean", "mean"),
    "wall pressure": ("lower", "upper", "lower"),
    "wall friction": ("upper", "upper", "lower"),
    "bottom load": ("lower", "lower", "upper"),
    "hopper filling": ("lower", "lower", "lower"),
    "hopper discharge": ("lower", "upper", "upper"),
    "eccentric discharge": ("lower", "upper", "upper"),
}
WALLS = ("D1", "D2", "D3")


@dataclass(frozen=True)
class Values:
    """Characteristic values that go together for one load."""

    weight_density_N_per_m3: float
    wall_friction: float
    pressure_ratio: float
    internal_friction_angle_deg: float


@dataclass(frozen=True)
class Solid:
    """Stored solid.

    Parameters
    ----------
    name : str
        Its name.
    lower_weight_density_N_per_m3, upper_weight_density_N_per_m3 : float
        gamma_l and gamma_u [N/m3]; loads are computed with gamma_u.
    angle_of_repose_deg : float
        phi_r [degrees].
    internal_friction_angle_deg, internal_friction_factor : float
        Mean phi_i [degrees] and a_phi.
    pressure_ratio, pressure_ratio_factor : float
        Mean K_m and a_K.
    wall_frictions : tuple of float
        Mean mu of a polished (D1), smooth (D2) and rough (D3) wall; a corrugated or profiled wall (D4) is not covered.
    wall_friction_factor : float
        Factor a_mu.
    patch_factor : float
        C_op, the solid's reference factor of patch loads.
    """

    name: str
    lower_weight_density_N_per_m3: float
    upper_weight_density_N_per_m3: float
    angle_of_repose_deg: float
    internal_friction_angle_deg: float
    internal_friction_factor: float
    pressure_ratio: float
    pressure_ratio_factor: float
    wall_frictions: tuple[float, float, float]
    wall_friction_factor: float
    patch_factor: float

    def __post_init__(self):
        if not 0.0 < self.lower_weight_density_N_per_m3 <= self.upper_weight_density_N_per_m3 < np.inf:
            raise ValueError(
                "weight densities must be positive, the upper not below the lower, got "
                f"{self.lower_weight_density_N_per_m3} and {self.upper_weight_density_N_per_m3}"
            )
        for name in ("internal_friction_factor", "pressure_ratio_factor", "wall_friction_factor"):
            if not 1.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be 1 or more, got {getattr(self, name)}")
        for angle in (self.angle_of_repose_deg, self.internal_friction_angle_deg * self.internal_friction_factor):
            if not 0.0 < angle < 90.0:
                raise ValueError(f"angles up to their upper value must be in (0, 90), got {angle}")
        if len(self.wall_frictions) != len(WALLS) or not all(mu > 0.0 for mu in self.wall_frictions):
            raise ValueError(f"wall_frictions must be three positive numbers, got {self.wall_frictions}")
        for name in ("pressure_ratio", "patch_factor"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")

    def extremes(self, load: str, wall: str = "D2") -> Values:
        """Return the characteristic values that give the extreme of a load on a wall of a category.

        Raises
        ------
        ValueError
            If the load is none of TABLE_3_1, or the wall none of D1, D2, D3.
        """
        if load not in TABLE_3_1:
            raise ValueError(f"load must be one of {', '.join(TABLE_3_1)}, got {load!r}")
        if wall not in WALLS:
            raise ValueError(f"wall must be one of {', '.join(WALLS)}, got {wall!r}")
        powers = [{"mean": 0, "upper": 1, "lower": -1}[which] for which in TABLE_3_1[load]]
        mu = self.wall_frictions[WALLS.index(wall)] * self.wall_friction_factor ** powers[0]
        angle = self.internal_friction_angle_deg * self.internal_friction_factor ** powers[2]
        return Values(
            weight_density_N_per_m3=self.upper_weight_density_N_per_m3,
            wall_friction=float(min(mu, np.tan(np.radians(angle)))),
            pressure_ratio=self.pressure_ratio * self.pressure_ratio_factor ** powers[1],
            internal_friction_angle_deg=angle,
        )


SAND = Solid("sand", 14e3, 16e3, 39.0, 36.0, 1.09, 0.45, 1.11, (0.38, 0.48, 0.57), 1.16, 0.4)
