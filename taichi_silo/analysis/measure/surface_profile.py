"""The free surface of sand that has spread: its height along x, how far its fronts reach, and its angle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TOP = 5  # strips over which the greatest height is a mean
CONTINUOUS = 0.5  # of a layer of points: where there is less, sand lies in single grains, and a front ends


@dataclass(frozen=True)
class SurfaceProfile:
    """Height of sand over strips of the floor.

    Attributes
    ----------
    edges_m : of the strips, rising (n + 1,) [m].
    height_m : area of sand over each strip, over its breadth (n,) [m].
    layer_m : height of one layer of points [m].

    """

    edges_m: NDArray
    height_m: NDArray
    layer_m: float

    @classmethod
    def of(cls, x: NDArray, area: NDArray, spacing_m: float, left_m: float, right_m: float, strips: int):
        """From points at x (n,) [m], each with its area (n,) [m2], spread over a spacing; ends of the floor [m]."""
        edges = np.linspace(left_m, right_m, strips + 1)
        breadth = edges[1] - edges[0]
        low = np.clip((x - 0.5 * spacing_m - left_m) / breadth, 0.0, strips)
        high = np.clip((x + 0.5 * spacing_m - left_m) / breadth, 0.0, strips)
        per_strip = area / np.maximum(high - low, 1e-12)
        over = np.zeros(strips)
        first, last = low.astype(int), np.ceil(high).astype(int)
        for offset in range(int((last - first).max(initial=0))):
            strip = first + offset
            share = np.minimum(high, strip + 1.0) - np.maximum(low, strip)
            there = (strip < strips) & (share > 0.0)
            over += np.bincount(strip[there], (per_strip * share)[there], minlength=strips)
        return cls(edges, over / breadth, spacing_m)

    @property
    def middle_m(self) -> NDArray:
        """Middles of the strips (n,) [m]."""
        return 0.5 * (self.edges_m[:-1] + self.edges_m[1:])

    def fronts_m(self, from_m: float) -> tuple[float, float]:
        """X of the left and right end of the sand that hangs together with that at `from_m` [m].

        A strip ends it that holds less than half a layer of points; of the last one as much counts as is covered by
        a layer.
        """
        least = CONTINUOUS * self.layer_m
        covered = self.height_m >= least
        here = int(np.clip(np.searchsorted(self.edges_m, from_m, side="right") - 1, 0, len(covered) - 1))
        if not covered[here]:
            return from_m, from_m
        gaps = np.flatnonzero(~covered)
        left, right = gaps[gaps < here].max(initial=-1), gaps[gaps > here].min(initial=len(covered))
        breadth = self.edges_m[1] - self.edges_m[0]
        beyond = [float(min(self.height_m[n] / least, 1.0)) if 0 <= n < len(covered) else 0.0 for n in (left, right)]
        return float(self.edges_m[left + 1] - beyond[0] * breadth), float(self.edges_m[right] + beyond[1] * breadth)

    @property
    def top_m(self) -> float:
        """Greatest height, a mean over five strips [m]: single ones hold a row of points more or less than others."""
        return float(np.convolve(self.height_m, np.full(TOP, 1.0 / TOP), mode="valid").max())

    def slope_deg(self, low: float = 0.2, high: float = 0.8) -> float:
        """Angle of the steeper side of the surface, between two shares of its greatest height [degrees]; nan if none.

        The straight line through the strips on the way from the top to a front.
        """
        smooth = np.convolve(self.height_m, np.full(TOP, 1.0 / TOP), mode="same")
        top, found = int(np.argmax(smooth)), []
        for side in (slice(top, None), slice(None, top + 1)):
            x, y = self.middle_m[side], self.height_m[side]
            between = (y > low * self.top_m) & (y < high * self.top_m)
            if between.sum() > 1:
                found.append(abs(float(np.polyfit(x[between], y[between], 1)[0])))
        return float(np.degrees(np.arctan(max(found)))) if found else float("nan")
