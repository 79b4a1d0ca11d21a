"""The one friction formula: how a wall changes the velocity of the sand that touches it.

The contract of a contact, a frozen dataclass: `touch(relative, normal)` takes the sand's trial velocity relative to
the wall [m/s] and the unit normal that points out of the sand, and returns the admissible relative velocity.
"""

import math
from dataclasses import dataclass

import taichi as ti


@dataclass(frozen=True)
class Coulomb:
    """Unilateral contact with Coulomb friction, by impulse (Bardenhagen et al. 2000).

    Sand that approaches loses its normal velocity; the tangential one falls by at most mu times that: it sticks
    where this suffices, else slips. Sand that recedes is free.
    """

    friction_angle_deg: float = 0.0

    @property
    def coefficient(self) -> float:
        """Friction coefficient mu."""
        return math.tan(math.radians(self.friction_angle_deg))

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity."""
        approach = ti.max(relative.dot(normal), 0.0)
        touched = relative - approach * normal
        if ti.static(self.coefficient > 0.0):
            sliding = relative - relative.dot(normal) * normal
            speed = sliding.norm() + 1e-300
            touched -= ti.min(self.coefficient * approach / speed, 1.0) * sliding
        return touched


@dataclass(frozen=True)
class NoSlip:
    """A very rough wall: the sand moves with it and does not part from it."""

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity: none."""
        return 0.0 * relative


@dataclass(frozen=True)
class Glide:
    """A smooth plate from which the sand does not part: the axis of symmetry, the plates of a specimen."""

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity: along the plate."""
        return relative - relative.dot(normal) * normal


@dataclass(frozen=True)
class Grip:
    """A rough plate that floats on the sand: no sliding, free along its normal (the top of a shear box)."""

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity: along the normal."""
        return relative.dot(normal) * normal
