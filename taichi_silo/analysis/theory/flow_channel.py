"""Wall pressures of a round slender silo that discharges far from its axis, after EN 1991-4:2006, 5.2.4.

Flow is confined to a vertical channel of radius r_c = G r that meets the wall over |theta| <= theta_c; e_c is the
distance of the axes of channel and silo:

    eta = mu / tan(phi_i),   e_c = r (eta (1 - G) + (1 - eta) sqrt(1 - G)),                          (5.55) to (5.57)
    cos(theta_c) = (r^2 + e_c^2 - r_c^2) / (2 r e_c),   sin(psi) = (r / r_c) sin(theta_c),           (5.58) to (5.59)
    U_wc = 2 theta_c r,   U_sc = 2 r_c (pi - psi),                                                   (5.60) to (5.61)
    A_c = (pi - psi) r_c^2 + theta_c r^2 - r r_c sin(psi - theta_c).                                          (5.62)

psi is the angle at the channel's axis to the edge of its contact. The channel hangs on the wall and on the fill at
rest, z_oc = (1/K) A_c / (U_wc mu + U_sc tan(phi_i)), p_hco = gamma K z_oc (5.65, 5.66), and presses less than at rest,

    p_hce = p_hco (1 - exp(-z / z_oc))          |theta| <= theta_c, in the channel
    p_hae = 2 p_hf - p_hce                      theta_c < |theta| <= 2 theta_c, beside it
    p_hse = p_hf                                beyond, p_hf of the filling (5.2.1.1),

so that the mean over the circumference is p_hf; friction is mu times each. The extent of the strip beside the channel
is taken from that balance; its number is not confirmed, nor those of the three pressures.

Three channels, G = 0.25, 0.4 and 0.6, are recommended; the largest eccentricity without all this is 0.25 d.
"""

from dataclasses import dataclass

import numpy as np

SIZE_RATIOS = (0.25, 0.4, 0.6)  # recommended G
CRITICAL_ECCENTRICITY = 0.25  # of the outlet, over the diameter


@dataclass(frozen=True)
class FlowChannel:
    """Channel of flow at the wall of a round silo.

    Parameters
    ----------
    radius_m : float
        Radius r of the silo [m].
    size_ratio : float
        G = r_c / r, in (0, 1).
    weight_density_N_per_m3 : float
        gamma [N/m3].
    wall_friction : float
        mu, positive and at most tan(phi_i) [-].
    pressure_ratio : float
        K [-].
    internal_friction_angle_deg : float
        phi_i, in (0, 90) [degrees].
    """

    radius_m: float
    size_ratio: float
    weight_density_N_per_m3: float
    wall_friction: float
    pressure_ratio: float
    internal_friction_angle_deg: float

    def __post_init__(self):
        for name in ("radius_m", "weight_density_N_per_m3", "wall_friction", "pressure_ratio"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be positive and finite, got {getattr(self, name)}")
        if not 0.0 < self.size_ratio < 1.0:
            raise ValueError(f"size_ratio must be in (0, 1), got {self.size_ratio}")
        if not 0.0 < self.internal_friction_angle_deg < 90.0:
            raise ValueError(f"internal_friction_angle_deg must be in (0, 90): {self.internal_friction_angle_deg}")
        if self.wall_friction > self._internal_friction * (1.0 + 1e-12):
            raise ValueError(f"wall_friction must not exceed {self._internal_friction:.6g}, got {self.wall_friction}")

    @property
    def _internal_friction(self) -> float:
        return float(np.tan(np.radians(self.internal_friction_angle_deg)))

    @property
    def channel_radius_m(self) -> float:
        """Radius r_c = G r of the channel [m]."""
        return self.size_ratio * self.radius_m

    @property
    def eccentricity_m(self) -> float:
        """Distance e_c of the axes of channel and silo [m]."""
        eta, rest = self.wall_friction / self._internal_friction, 1.0 - self.size_ratio
        return float(self.radius_m * (eta * rest + (1.0 - eta) * np.sqrt(rest)))

    @property
    def contact_angle_deg(self) -> float:
        """Half angle theta_c of the contact of channel and wall at the silo's axis [degrees]."""
        r, e, r_c = self.radius_m, self.eccentricity_m, self.channel_radius_m
        return float(np.degrees(np.arccos(min((r**2 + e**2 - r_c**2) / (2.0 * r * e), 1.0))))

    @property
    def channel_angle_deg(self) -> float:
        """Half angle psi of that contact at the channel's axis [degrees]."""
        theta = np.radians(self.contact_angle_deg)
        across, along = self.radius_m * np.sin(theta), self.radius_m * np.cos(theta) - self.eccentricity_m
        return float(np.degrees(np.arctan2(across, along)))

    @property
    def wall_perimeter_m(self) -> float:
        """Perimeter U_wc of the channel at the wall [m]."""
        return 2.0 * np.radians(self.contact_angle_deg) * self.radius_m

    @property
    def fill_perimeter_m(self) -> float:
        """Perimeter U_sc of the channel at the fill at rest [m]."""
        return 2.0 * self.channel_radius_m * (np.pi - np.radians(self.channel_angle_deg))

    @property
    def area_m2(self) -> float:
        """Area A_c of the channel [m2]."""
        theta, psi = np.radians(self.contact_angle_deg), np.radians(self.channel_angle_deg)
        r, r_c = self.radius_m, self.channel_radius_m
        return float((np.pi - psi) * r_c**2 + theta * r**2 - r * r_c * np.sin(psi - theta))

    @property
    def depth_scale_m(self) -> float:
        """Depth z_oc over which the channel's weight is taken up [m]."""
        resistance = self.wall_perimeter_m * self.wall_friction + self.fill_perimeter_m * self._internal_friction
        return float(self.area_m2 / (self.pressure_ratio * resistance))

    def _janssen(self, depth_m, scale_m):
        depth = np.asarray(depth_m, dtype=float)
        if np.any(~(depth >= 0.0)):
            raise ValueError(f"depth_m must be 0 or more, got {depth_m}")
        return -self.pressure_ratio * self.weight_density_N_per_m3 * scale_m * np.expm1(-depth / scale_m)

    def static_normal_Pa(self, depth_m):
        """Pressure p_hse = p_hf far from the channel [Pa]."""
        return self._janssen(depth_m, 0.5 * self.radius_m / (self.pressure_ratio * self.wall_friction))

    def channel_normal_Pa(self, depth_m):
        """Pressure p_hce in the channel [Pa]."""
        return self._janssen(depth_m, self.depth_scale_m)

    def adjacent_normal_Pa(self, depth_m):
        """Pressure p_hae beside the channel [Pa]."""
        return 2.0 * self.static_normal_Pa(depth_m) - self.channel_normal_Pa(depth_m)

    def wall_normal_Pa(self, depth_m, angle_deg):
        """Wall pressure at a depth and an angle from the middle of the channel, in [-180, 180] [Pa]."""
        angle = np.abs(np.asarray(angle_deg, dtype=float))
        if np.any(~(angle <= 180.0)):
            raise ValueError(f"angle_deg must be in [-180, 180], got {angle_deg}")
        static, channel = self.static_normal_Pa(depth_m), self.channel_normal_Pa(depth_m)
        beside = np.where(angle <= 2.0 * self.contact_angle_deg, 2.0 * static - channel, static)
        return np.where(angle <= self.contact_angle_deg, channel, beside)
