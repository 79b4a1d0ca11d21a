"""A mean over the neighbours of each point within a radius: sparse rows of normalised weights."""

import math
from collections.abc import Sequence

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.contracts import Kernel
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.means import Means
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real, whole_numbers

MOST_PAIRS = 500_000_000  # 6 GB
MOST_BINS = 4_000_000
ROOM = 1.6  # of the pairs that a regular lattice would have


def most_pairs(radius_m: float, spacing_m: float, count: int) -> int:
    """Room for the pairs of so many points on a lattice within a radius, with some to spare."""
    return int(min(count**2, count * (ROOM * math.pi * (radius_m / spacing_m) ** 2 + 12)))


@ti.data_oriented
class NeighbourRows(Means):
    """A row for each point: its neighbours (itself is one), and their weights over the sum of the row.

    Points are sorted into square bins as wide as the kernel's radius, so a row is looked for in nine bins: cost and
    memory grow with the number of pairs, 12 bytes each.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    start           point + 2   where the row of a point begins in the next two; the last row is empty
    neighbour       pair        number of a neighbour
    share           pair        its normalised weight, w V / sum [-]
    value           point + 1   what each point handed in
    ==============  ==========  ========================================================================

    Parameters
    ----------
    spacing_m : of the points at the start.
    others : see `Means`.

    """

    def __init__(
        self, kernel: Kernel, particles: Particles, spacing_m: float,
        rigid_planes: Sequence[tuple[int, int, float]] = (), alike_along_x: bool = False,
    ):  # fmt: skip
        super().__init__(kernel, particles, rigid_planes, alike_along_x)
        self.radius = kernel.radius
        count = particles.count
        self.room = count**2 if alike_along_x else most_pairs(self.radius, spacing_m, count)
        self.start, self.neighbour = whole_numbers((count + 2,), (self.room,))
        self.share = ti.field(real, shape=self.room)
        self.value = ti.field(real, shape=count + 1)

    @property
    def pairs(self) -> int:
        """Number of weights in use."""
        return int(self.start[self.particles.count])

    def _build(self, place: np.ndarray) -> None:
        """Build all rows.

        Raises
        ------
        RunFailed
            if points have come so close that the pairs exceed their room.

        """
        low = place.min(axis=0)
        extent = np.ptp(place, axis=0) + self.radius
        width = max(self.radius, math.sqrt(float(extent.prod()) / MOST_BINS), float(extent.max()) / MOST_BINS)
        bins = np.floor((place - low) / width).astype(np.int64)
        across = int(bins[:, 0].max()) + 1
        number = bins[:, 1] * across + bins[:, 0]
        order = np.argsort(number, kind="stable").astype(np.int32)
        # a bin's points stand together in `order`; three neighbouring bins of a row as well
        rows = int(bins[:, 1].max()) + 1
        first = np.searchsorted(number[order], np.arange(across * rows + 1)).astype(np.int32)
        length = np.zeros(len(place), dtype=np.int32)
        self._count(order, first, bins.astype(np.int32), across, rows, length)
        start = np.concatenate([[0], np.cumsum(length, dtype=np.int64)])
        if start[-1] > self.room:
            raise RunFailed(
                f"because {start[-1]} pairs of neighbours exceed the room for {self.room}: points have clumped"
            )
        full = np.full(self.particles.count + 2, start[-1], dtype=np.int32)
        full[: len(start)] = start
        put(self.start, full)
        self._fill(order, first, bins.astype(np.int32), across, rows)

    @ti.func
    def give(self, store: ti.template(), p, value, copy):
        """Hand in the value of point number p."""
        self.value[p] = value

    @ti.func
    def mean(self, p):
        """The mean around point number p."""
        total = 0.0
        for k in range(self.start[p], self.start[p + 1]):
            total += self.share[k] * self.value[self.neighbour[k]]
        return total

    @ti.kernel
    def _count(
        self, order: ti.types.ndarray(), first: ti.types.ndarray(), bins: ti.types.ndarray(), across: ti.i32,
        rows: ti.i32, length: ti.types.ndarray(),
    ):  # fmt: skip
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            here = self.particles.position[p]
            found = 0
            for row in range(ti.max(bins[p, 1] - 1, 0), ti.min(bins[p, 1] + 2, rows)):
                left = row * across + ti.max(bins[p, 0] - 1, 0)
                right = row * across + ti.min(bins[p, 0] + 2, across)
                for k in range(first[left], first[right]):
                    if self._distance(self.particles.position[order[k]], here) <= self.radius:
                        found += 1
            length[p] = found

    @ti.kernel
    def _fill(
        self, order: ti.types.ndarray(), first: ti.types.ndarray(), bins: ti.types.ndarray(), across: ti.i32,
        rows: ti.i32,
    ):  # fmt: skip
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            here = self.particles.position[p]
            at, total = self.start[p], 0.0
            for row in range(ti.max(bins[p, 1] - 1, 0), ti.min(bins[p, 1] + 2, rows)):
                left = row * across + ti.max(bins[p, 0] - 1, 0)
                right = row * across + ti.min(bins[p, 0] + 2, across)
                for k in range(first[left], first[right]):
                    q = order[k]
                    distance = self._distance(self.particles.position[q], here)
                    if distance <= self.radius:
                        share = self.kernel.weight(distance) * self.particles.volume[q]
                        self.neighbour[at], self.share[at] = q, share
                        at, total = at + 1, total + share
            for k in range(self.start[p], at):
                self.share[k] = self.share[k] * self.sand[p] / total
