"""Noise control of quasi-static flow: what keeps the column's own oscillation from ratcheting the sand.

The contract, a frozen dataclass of compile-time constants:

`drag`          rate d of a nodal force -m d (v - memory) [1/s]
`flow_strength` times which it acts in flow whose bottom has its speed [-]
`memory_time`   time constant of the exponential mean `memory` of the nodal velocity [s]
`filling_drag`  rate of an extra force -m d v while the silo is being filled [1/s]
`relaxation`    rate at which the points' velocities relax to the grid's [1/s]; it removes what the grid cannot see

All zero is the paper's "no damping was defined".
"""

import math

from taichi_silo.mpm.frozen import frozen


@frozen
class NoiseControl:
    """A drag towards the recent mean motion, and a slow relaxation of the points to the grid.

    The drag is no force in steady flow. The relaxation (a PIC share of rate times dt in each step) acts on
    grid-visible motion as a viscosity of density * rate * h^2 / 4, below 1 Pa s on the paper's grid; without it, pure
    FLIP lets velocities that cancel at the nodes grow in a shear zone to many times those of the flow.
    """

    drag: float = 0.0
    memory_time: float = 0.05
    filling_drag: float = 0.0
    relaxation: float = 0.0
    flow_strength: float = 1.0

    @classmethod
    def for_column(cls, period_s: float, slenderness: float = 1.0, strength: float = 1.0) -> "NoiseControl":
        """Scaled to the slowest mode of the column, of the given period 4 H / c [s].

        A memory of an eighth of the period leaves 0.38 of the drag to that mode and nearly all of it to faster ones,
        and weighs on slow changes as an inertia of one more mass only (drag times memory), so that it neither bends
        the filling nor lags behind the bottom. Friction feeds the mode the more, the rougher the wall and the more wall
        there is for the sand: beyond a height of four widths the drag grows with height over width (`slenderness`);
        `strength` multiplies it in flow. While the silo is being filled a drag towards rest, an eighth of the usual
        one, comes on top.
        """
        swing = 2.0 * math.pi / period_s
        drag = 1.28 * swing * max(1.0, 0.25 * slenderness)
        return cls(drag, 0.125 * period_s, 0.16 * swing, 0.16 * swing, strength)

    @classmethod
    def for_specimen(cls, period_s: float, cell_transit_s: float) -> "NoiseControl":
        """For a body whose sand yields everywhere: a weak drag with a long memory, and points that follow the grid.

        Yielding sand feeds what the grid cannot see at the pace of waves through a cell (h / c, the second argument),
        so the relaxation has to keep up with them: 0.12 c / h, a viscosity of 0.03 density c h (30 Pa s for 2.5 mm),
        which is a thousandth of the stresses of a biaxial test at 50 mm/s.
        """
        rate = 0.16 * 2.0 * math.pi / period_s
        return cls(drag=rate, memory_time=2.5 * period_s, relaxation=0.12 / cell_transit_s)

    @property
    def brakes(self) -> bool:
        """Whether it ever acts on nodes."""
        return self.drag > 0.0 or self.filling_drag > 0.0

    def rates(self, stage: str) -> tuple[float, float]:
        """Of the drag towards the recent motion and of that towards rest, in "filling", "start" or "flow" [1/s].

        At the start, while the bottom gets its speed, a stronger drag would weigh on the sand as inertia.
        """
        strength = self.flow_strength if stage == "flow" else 1.0
        return strength * self.drag, self.filling_drag if stage == "filling" else 0.0

    def slows(self) -> float:
        """How many times as long a slow swing takes in flow, because the drag weighs on it as inertia [-]."""
        return math.sqrt(1.0 + self.rates("flow")[0] * self.memory_time)
