"""How a point gets its velocity from the grid.

The contract, a frozen dataclass:

`GRADIENT`
    "none", or which velocity gradient the points carry and give to the nodes: "affine" (of APIC) or "strain" (that of
    the strain rate).
`SECOND_TRANSFER`
    whether velocities go to the nodes and back once more in the step.
`carried(old, grid, change, second, dt)`
    the point's new velocity [m/s] from its old one, the grid's new velocity and its change in the step at the point,
    and, with SECOND_TRANSFER, what comes back of the grid's old velocity after one more trip to the nodes.
"""

from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.language import ti


@frozen
class Flip:
    """The change only, so nothing is smeared, and nothing that the grid cannot see is damped."""

    GRADIENT, SECOND_TRANSFER = "none", False

    @ti.func
    def carried(self, old, grid, change, second, dt):
        """Old velocity and change."""
        return old + change


@frozen
class Pic:
    """The grid's velocity itself: a viscosity of about density h^2 / (4 dt)."""

    GRADIENT, SECOND_TRANSFER = "none", False

    @ti.func
    def carried(self, old, grid, change, second, dt):
        """Velocity of the grid."""
        return grid


@frozen
class Blend:
    """FLIP with a share of PIC in each step."""

    share: float = 0.05

    GRADIENT, SECOND_TRANSFER = "none", False

    @ti.func
    def carried(self, old, grid, change, second, dt):
        """Weighted mean of both."""
        return (1.0 - self.share) * (old + change) + self.share * grid


@frozen
class Enhanced(Flip):
    """FLIP, whose points give the nodes their velocity gradient as well (Wallstedt and Guilkey 2007)."""

    GRADIENT = "strain"


@frozen
class Apic(Pic):
    """PIC with an affine velocity field in each point (Jiang et al. 2015): keeps angular momentum."""

    GRADIENT = "affine"


@frozen
class Xpic:
    """XPIC of order 2 (Hammerquist and Nairn 2017): PIC that leaves what the grid sees, to second order.

    With P the trip to the nodes and back, the old velocities V become 2 P V - P P V.
    """

    GRADIENT, SECOND_TRANSFER = "none", True

    @ti.func
    def carried(self, old, grid, change, second, dt):
        """Twice P V less P P V, and the change; `grid` is P V and the change."""
        return grid + (grid - change) - second


TRANSFERS = {"flip": Flip, "pic": Pic, "blend": Blend, "gradient": Enhanced, "apic": Apic, "xpic": Xpic}
