"""Janssen's theory between walls whose friction changes from band to band (see `janssen`).

Within a layer of friction coefficient mu, below a vertical stress s on its top,

    sigma_v = s exp(-z / z0) + gamma z0 (1 - exp(-z / z0)),   z0 = (A / U) / (K mu),

z being the depth below its top; what a layer ends with the next begins with. Where both walls of a plane silo differ,
mu is their mean: the slice feels the sum of both.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import exprel

from taichi_silo.analysis.root import root
from taichi_silo.analysis.theory.janssen import PERIMETER, Janssen, _mean_growth


@dataclass(frozen=True)
class BandedJanssen(Janssen):
    """Fill between walls with layers of friction; `wall_friction_angle_deg` is arctan(T / N) of a whole wall."""

    layers: tuple[tuple[float, float], ...] = ()  # height [m] and mu [-] of each, from the surface down

    @classmethod
    def through(
        cls, width_m: float, weight_density_N_per_m3: float, pressure_ratio: float, section: str,
        layers: tuple[tuple[float, float], ...],
    ) -> "BandedJanssen":  # fmt: skip
        """The theory of layers, each of a height [m] and a friction coefficient, from the surface down."""
        height = sum(height for height, _ in layers)
        found = cls(width_m, height, weight_density_N_per_m3, 0.0, pressure_ratio, section, layers)
        angle = np.degrees(np.arctan2(found.shear_force_N_per_m, found.normal_force_N_per_m))
        return replace(found, wall_friction_angle_deg=float(angle))

    def __post_init__(self) -> None:
        super().__post_init__()
        for height, mu in self.layers:
            if not height > 0.0 or not mu >= 0.0:
                raise ValueError(
                    f"a layer is {height} m high with friction {mu}; both must be positive, friction may be 0"
                )

    def _resistance(self, mu: float) -> float:
        """1 / z0 of a layer [1/m]."""
        return PERIMETER[self.section] * self.pressure_ratio * mu / self.width_m

    def _stations(self) -> list[tuple[float, float, float, float]]:
        """Depth and vertical stress at the top of each layer, its height and its friction."""
        found, depth, stress = [], 0.0, 0.0
        for height, mu in self.layers:
            found.append((depth, stress, height, mu))
            stress = float(self._within(height, stress, mu))
            depth += height
        return found

    def _within(self, z: ArrayLike, top: float, mu: float) -> NDArray:
        """Vertical stress at a depth z below the top of a layer [Pa]."""
        z, r = np.asarray(z, float), self._resistance(mu)
        return top * np.exp(-r * z) + self.weight_density_N_per_m3 * z * exprel(-r * z)

    def vertical_stress_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Mean vertical stress sigma_v at a depth (number or array) below the free surface [Pa]."""
        depth = np.asarray(depth_m, float)
        found = np.zeros(depth.shape)
        for start, top, _height, mu in self._stations():
            found = np.where(depth >= start, self._within(np.maximum(depth - start, 0.0), top, mu), found)
        return found

    def friction_at(self, depth_m: ArrayLike) -> NDArray:
        """Friction coefficient at a depth (number or array) [-]."""
        depth = np.asarray(depth_m, float)
        found = np.zeros(depth.shape)
        for start, _top, _height, mu in self._stations():
            found = np.where(depth >= start, mu, found)
        return found

    def shear_stress_Pa(self, depth_m: ArrayLike) -> NDArray:
        """Wall shear stress mu K sigma_v at a depth (number or array), the mean of both walls [Pa]."""
        return self.friction_at(depth_m) * self.normal_stress_Pa(depth_m)

    def _normal_forces(self) -> list[tuple[float, float]]:
        """Normal force on a wall in each layer [N per metre], and its friction."""
        found = []
        for _depth, top, height, mu in self._stations():
            x = self._resistance(mu) * height
            stress = top * height * float(exprel(-x)) + self.weight_density_N_per_m3 * height**2 * _mean_growth(x)
            found.append((self.pressure_ratio * stress, mu))
        return found

    @property
    def normal_force_N_per_m(self) -> float:
        """Normal force N on one wall [N per metre]."""
        return sum(force for force, _ in self._normal_forces())

    @property
    def shear_force_N_per_m(self) -> float:
        """Friction force T on one wall, the mean of both [N per metre]."""
        return sum(mu * force for force, mu in self._normal_forces())

    def fitted(self, normal_force_N_per_m: float) -> float:
        """The pressure ratio with which the theory gives a normal force on one wall.

        Raises ValueError if none between 1e-6 and 100 does.
        """

        def beyond(ratio: float) -> float:
            return replace(self, pressure_ratio=ratio).normal_force_N_per_m - normal_force_N_per_m

        low, high = 1e-6, 100.0
        if not beyond(low) < 0.0 < beyond(high):
            raise ValueError(f"no pressure ratio gives a wall normal force of {normal_force_N_per_m:.6g} N/m")
        return root(beyond, low, high)
