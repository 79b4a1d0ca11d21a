"""Noise control of quasi-static flow: what keeps the column's own oscillation from ratcheting the sand.

The contract, a frozen dataclass of compile-time constants:

`drag`          rate d of a nodal force -m d (v - memory) [1/s]
`memory_time`   time constant of the exponential mean `memory` of the nodal velocity [s]
`filling_drag`  rate of an extra force -m d v while the silo is being filled [1/s]

All zero is the paper's "no damping was defined".
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class NoiseControl:
    """A drag towards the recent mean motion: no force in steady flow."""

    drag: float = 0.0
    memory_time: float = 0.05
    filling_drag: float = 0.0

    @classmethod
    def for_column(cls, period_s: float) -> "NoiseControl":
        """Scaled to the slowest mode of the column, of the given period 4 H / c [s]."""
        omega = 2.0 * math.pi / period_s
        return cls(drag=0.16 * omega, memory_time=2.5 * period_s, filling_drag=0.16 * omega)
