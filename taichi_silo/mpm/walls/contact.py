"""The one friction formula: how a wall changes the velocity of the sand that touches it.

The contract of a contact, a frozen dataclass: `touch(relative, normal)` takes the sand's trial velocity relative to
the wall [m/s] and the unit normal that points out of the sand, and returns the admissible relative velocity; all are
pairs (x, y).
"""

import math

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti


@frozen
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
        along = relative[0] * normal[0] + relative[1] * normal[1]
        return self.slow(relative, normal, along, self.coefficient * ti.max(along, 0.0))

    @ti.func
    def slow(self, relative, normal, along, friction):
        """Admissible relative velocity if `along` approaches and the tangential one falls by at most `friction`."""
        approach = ti.max(along, 0.0)
        x, y = relative[0] - approach * normal[0], relative[1] - approach * normal[1]
        if ti.static(self.coefficient > 0.0):
            sliding_x, sliding_y = relative[0] - along * normal[0], relative[1] - along * normal[1]
            speed = ti.sqrt(sliding_x * sliding_x + sliding_y * sliding_y) + 1e-300
            loss = ti.min(friction / speed, 1.0)
            x, y = x - loss * sliding_x, y - loss * sliding_y
        return x, y


@frozen
class NoSlip:
    """A very rough wall: the sand moves with it and does not part from it."""

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity: none."""
        return 0.0 * relative[0], 0.0 * relative[1]


@frozen
class Frictionless:
    """A smooth plate from which the sand does not part: the axis of symmetry, the plates of a specimen."""

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity: along the plate."""
        along = relative[0] * normal[0] + relative[1] * normal[1]
        return relative[0] - along * normal[0], relative[1] - along * normal[1]


@frozen
class RoughFree:
    """A rough plate that floats on the sand: no sliding, free along its normal (the top of a shear box)."""

    @ti.func
    def touch(self, relative, normal):
        """Admissible relative velocity: along the normal."""
        along = relative[0] * normal[0] + relative[1] * normal[1]
        return along * normal[0], along * normal[1]
