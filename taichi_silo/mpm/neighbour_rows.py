"""Neighbours of each point within a radius, as sparse rows of normalised weights."""

import math
from collections.abc import Sequence

import numpy as np
import taichi as ti

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.contracts import Kernel
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real, whole_numbers

MOST_PAIRS = 500_000_000  # 6 GB
MOST_BINS = 4_000_000
ROOM = 1.6  # of the pairs that a regular lattice would have


def most_pairs(radius_m: float, spacing_m: float, count: int) -> int:
    """Room for the pairs of so many points on a lattice within a radius, with some to spare."""
    return int(min(count**2, count * (ROOM * math.pi * (radius_m / spacing_m) ** 2 + 12)))


@ti.data_oriented
class NeighbourRows:
    """A row for each point: its neighbours (itself is one), and their weights over the sum of the row.

    Points are sorted into square bins as wide as the radius, so a row is looked for in nine bins: cost and memory grow
    with the number of pairs, 12 bytes each.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    start           point + 2   where the row of a point begins in the next two; the last row is empty
    neighbour       pair        number of a neighbour
    share           pair        its normalised weight, w V / sum [-]
    place           point, 2    position when the rows were built [m]
    ==============  ==========  ========================================================================

    Parameters
    ----------
    kernel : with `weight(distance)`, before normalisation.
    radius : within which points are neighbours [m].
    particles : the points.
    spacing_m : of the points at the start.
    rigid_planes : (axis, side, coordinate [m]) of planes beyond which nothing strains, yet counts: the kernel's share
        beyond them joins the sum of a row. `side` is the sign of the normal out of the points.
    alike_along_x : whether every field is alike along x, as in a periodic strip: distances are then along y only, which
        is what remains of a Gaussian over the whole plane.

    Attributes
    ----------
    builds : how often the rows were built.
    revision : of the particles that they were built from, -1 at first.
    origin : positions and volumes of the points that they were built from.

    """

    def __init__(
        self, kernel: Kernel, radius: float, particles: Particles, spacing_m: float,
        rigid_planes: Sequence[tuple[int, int, float]] = (), alike_along_x: bool = False,
    ):  # fmt: skip
        self.rigid_planes = tuple(rigid_planes)
        self.kernel, self.radius, self.particles = kernel, radius, particles
        self.counts = (0.0, 1.0) if alike_along_x else (1.0, 1.0)  # how much of x and y a distance counts
        self.builds, self.revision = 0, -1
        self.origin: dict[str, np.ndarray] = {}
        count = particles.count
        self.room = count**2 if alike_along_x else most_pairs(radius, spacing_m, count)
        self.start = whole_numbers(count + 2)
        self.neighbour = whole_numbers(self.room)
        self.share = ti.field(real, shape=self.room)
        self.place = ti.Vector.field(2, real, shape=count)
        self.sand = ti.field(real, shape=count)  # share of the kernel on this side of the rigid planes

    @property
    def pairs(self) -> int:
        """Number of weights in use."""
        return int(self.start[self.particles.count])

    def update(self, allowed_m: float) -> None:
        """Build the rows anew if there are none of these particles, or a point has moved further than allowed [m]."""
        if self.revision != self.particles.revision or self._moved() > allowed_m:
            self.build()

    def forget(self) -> None:
        """Have no rows until the next update."""
        self.revision = -1

    def build(self) -> None:
        """Build all rows; points whose place is no number leave the rows as they are.

        Raises
        ------
        RunFailed
            if points have come so close that the pairs exceed their room.

        """
        active = self.particles.active[None]
        place = self.particles.position.to_numpy()[:active]
        if not np.isfinite(place).all():
            return  # the guard will stop the run
        self.origin = {"position": place, "volume": self.particles.volume.to_numpy()[:active]}
        place = place * self.counts
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
        self.start.from_numpy(full)
        self.sand.from_numpy(np.pad(self._share_of_sand(place), (0, self.particles.count - active)))
        self._fill(order, first, bins.astype(np.int32), across, rows)
        self.builds += 1
        self.revision = self.particles.revision

    def _share_of_sand(self, place: np.ndarray) -> np.ndarray:
        """Share of the kernel around each place that lies on the points' side of all rigid planes."""
        beyond = np.zeros((2, len(place)))  # of planes across each axis: of parallel ones, the shares add up
        for axis, side, coordinate in self.rigid_planes:
            distance = side * (coordinate - place[:, axis])
            near = distance < self.radius
            beyond[axis, near] += [self.kernel.beyond(value) for value in distance[near]]
        return np.prod(1.0 - beyond, axis=0)

    @ti.func
    def mean(self, values: ti.template(), p):
        """Weighted mean over the neighbours of point p of a scalar field by points."""
        total = 0.0
        for k in range(self.start[p], self.start[p + 1]):
            total += self.share[k] * values[self.neighbour[k]]
        return total

    @ti.func
    def _distance(self, a, b):
        return ((a - b) * ti.Vector(self.counts)).norm()

    @ti.kernel
    def _moved(self) -> real:
        most = 0.0
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            ti.atomic_max(most, self._distance(self.particles.position[p], self.place[p]))
        return most

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
            self.place[p] = here
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
