"""Linear hat functions: the standard material point method, with its cell-crossing error."""

import math
from dataclasses import dataclass

import taichi as ti


@dataclass(frozen=True)
class Linear:
    """Two nodes an axis; the gradient jumps where a point crosses a cell edge."""

    half_size: float = 0.0  # of the point's domain in grid units; a hat function ignores the domain

    NODES = 2

    @property
    def stable_fraction(self) -> float:
        """That of a point at the centre of its cell; next to an edge there is no bound at all."""
        return 2.0 / math.sqrt(2.0 * 4.0)

    @ti.func
    def axis(self, xi):
        """First node, two weights, two derivatives."""
        base = ti.floor(xi)
        a = xi - base
        one = 0.0 * a + 1.0
        return base, (1.0 - a, a), (0.0 - one, one)
