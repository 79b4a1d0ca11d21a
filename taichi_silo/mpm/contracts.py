"""What the parts of the method offer to ordinary Python; what kernels call is in the packages' docstrings.

`laws`, `shapes`, `walls`, `velocity_transfer`, `filters` and `nonlocal_average` say the whole contract of each part.
"""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np


class Shape(Protocol):
    """A shape function (see `shapes`)."""

    @property
    def half_size(self) -> float:
        """Half the edge of a point's first domain [cells]."""

    @property
    def stable_fraction(self) -> float:
        """Largest stable time step over h / c."""

    @property
    def PATCHES(self) -> int:
        """Rectangles of nodes that a point touches."""

    @property
    def NODES(self) -> int:
        """Nodes along the edge of a rectangle."""

    @property
    def DOMAIN(self) -> bool:
        """Whether points carry a domain."""


class Law(Protocol):
    """A constitutive law (see `laws`)."""

    @property
    def grain_density(self) -> float:
        """[kg/m3]."""

    @property
    def rest_stress(self) -> float:
        """Isotropic pressure of unloaded material [Pa]."""

    @property
    def degree(self) -> float:
        """Of the rate as a homogeneous function of the stress."""

    @property
    def REMEMBERS(self) -> bool:
        """Whether points carry intergranular strain."""

    def rest_pressure_ratio(self, void_ratio: float) -> float:
        """K0 that one-dimensional compression tends to at a void ratio."""


class Transfer(Protocol):
    """How a point gets its velocity from the grid (see `velocity_transfer`)."""

    @property
    def GRADIENT(self) -> str:
        """Which velocity gradient points carry: "none", "affine" or "strain"."""

    @property
    def SECOND_TRANSFER(self) -> bool:
        """Whether velocities go to the nodes and back once more."""


class Wall(Protocol):
    """A wall that holds nodes (see `walls`)."""

    @property
    def name(self) -> str:
        """As it is called in results."""

    @property
    def motion(self) -> tuple[float, float]:
        """Its velocity along x and y, as multiples of the plate velocity of the step."""


class Kernel(Protocol):
    """A weight of neighbours (see `nonlocal_average`)."""

    @property
    def length_m(self) -> float:
        """Characteristic length l_c [m]."""


Filter = Callable[[Any, Any, Any, bool], Any]  # class of a stress filter: particles, grid, law, mirrored
Numbers = np.ndarray | tuple[float, ...] | list[float]
