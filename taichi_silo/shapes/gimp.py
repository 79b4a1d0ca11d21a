"""Generalised interpolation (Bardenhagen and Kober 2004) with domains of fixed size: uGIMP."""

import math
from dataclasses import dataclass

import numpy as np
import taichi as ti


@dataclass(frozen=True)
class UniformGimp:
    """Hat functions averaged over a point's domain, which keeps its initial size.

    With the domain from a to b = a + 2 l (measured from the first touched node, in cells, l <= 1/2) the averages are
    integrals of straight lines, so that weights and gradients need no case distinction.
    """

    half_size: float = 0.5  # l of the point's domain, in grid units: 1/2 for one point a cell, 1/4 for four

    NODES = 3

    def __post_init__(self):
        if not 0.0 < self.half_size <= 0.5:
            raise ValueError(f"half size of a domain is {self.half_size} cells; it must be above 0 and at most 0.5")

    @property
    def stable_fraction(self) -> float:
        """Numerical maximum over the position in a cell: 0.577 for l = 1/2, 0.463 for l = 1/4."""
        l = self.half_size  # noqa: E741
        a = np.linspace(1e-9, 1.0 - 1e-9, 20001)
        end, over = np.minimum(a + 2 * l, 1.0), np.maximum(a + 2 * l - 1.0, 0.0)
        weights = [((1 - a) ** 2 - (1 - end) ** 2) / (4 * l), over**2 / (4 * l)]
        slopes = [(a - end) / (2 * l), over / (2 * l)]
        weights.append(1.0 - weights[0] - weights[1])
        slopes.append(-slopes[0] - slopes[1])
        total = sum(np.where(s > 0, g**2 / np.maximum(s, 1e-300), 0.0) for s, g in zip(weights, slopes, strict=True))
        return 2.0 / math.sqrt(2.0 * float(total.max()))

    @ti.func
    def axis(self, xi):
        """First node, three weights, three derivatives."""
        start = xi - self.half_size
        base = ti.floor(start)
        a = start - base
        b = a + 2.0 * self.half_size
        end = ti.min(b, 1.0)
        over = ti.max(b - 1.0, 0.0)
        s0 = ((1.0 - a) ** 2 - (1.0 - end) ** 2) * (0.25 / self.half_size)
        s2 = over * over * (0.25 / self.half_size)
        g0 = (a - end) * (0.5 / self.half_size)
        g2 = over * (0.5 / self.half_size)
        return base, (s0, 1.0 - s0 - s2, s2), (g0, 0.0 - g0 - g2, g2)
