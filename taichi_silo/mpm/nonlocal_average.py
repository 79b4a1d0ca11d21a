"""The non-local norm of the strain rate: a weighted mean of ||D|| over the neighbours of a point.

    d_bar(x) = sum_q w(|x - x_q|) V_q ||D_q|| / sum_q w(|x - x_q|) V_q

The sum runs over the points that exist, so that a homogeneous field stays as it is next to a wall or a free surface.
A new weight is a subclass of `Weight`, or has its members, and a name in `WEIGHTS`.
"""

import math
from dataclasses import dataclass

import numpy as np
import taichi as ti

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import LANES, eight, real, wide

TOLERANCE = 0.02  # of l_c: no point should move so far on the same rows; from half of it on they are built anew
MOST_STEPS = 500  # between two looks at how far points have moved
MOST_PAIRS = 500_000_000  # 6 GB
INACTIVE_FROM = 0.99  # share of a point's own weight from which averaging changes nothing
MOST_BINS = 4_000_000
ROOM = 1.6  # of the pairs that a regular lattice would have


@dataclass(frozen=True)
class Weight:
    """exp(-(r / l_c)^POWER), cut off at CUT l_c, where it is 1e-4."""

    length_m: float

    POWER = 2
    CUT = 3.0

    @ti.func
    def weight(self, distance):
        """Of a neighbour, before normalisation."""
        return ti.exp(-((distance / self.length_m) ** self.POWER))


class Gaussian(Weight):
    """What the authors computed with."""


class Exponential(Weight):
    """exp(-r / l_c), as printed in the paper's equation 2."""

    POWER = 1
    CUT = 9.0


WEIGHTS = {"gaussian": Gaussian, "exponential": Exponential}


class Local:
    """No averaging: d_bar = ||D||."""

    ACTIVE = False


def self_weight(kernel: Weight, spacing_m: float) -> float:
    """Share of a point's own weight on a square lattice; near 1 the average is local (Python scope)."""
    reach = math.floor(kernel.CUT * kernel.length_m / spacing_m)
    along = np.arange(-reach, reach + 1) * spacing_m
    distance = np.hypot(*np.meshgrid(along, along))
    distance = distance[distance <= kernel.CUT * kernel.length_m]
    return float(1.0 / np.exp(-((distance / kernel.length_m) ** kernel.POWER)).sum())


def most_pairs(kernel: Weight, spacing_m: float, count: int) -> int:
    """Room for the pairs of so many points on a lattice, with some to spare (Python scope)."""
    return int(min(count**2, count * (ROOM * math.pi * (kernel.CUT * kernel.length_m / spacing_m) ** 2 + 12)))


@ti.data_oriented
class NonLocal:
    """Rows of weights over the neighbours of each point, kept until a point has moved 0.01 to 0.02 l_c.

    Points are sorted into square bins as wide as the radius of influence, so a row is looked for in nine bins: cost
    and memory grow with the number of pairs, 12 bytes each.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    start           point + 1   where the row of a point begins in the next two
    neighbour       pair        index of a neighbour (the point itself is one)
    share           pair        its normalised weight, w V / sum
    norm            point       ||D|| of the present step [1/s]
    motion          8 points    strain rate (4), spin and norm of the present step, six groups of eight [1/s]
    place           point, 2    position when the rows were built [m]
    ==============  ==========  ========================================================================

    Parameters
    ----------
    kernel : of `WEIGHTS`, with its length.
    particles : the points.
    spacing_m : of the points at the start.
    tolerance : displacement of a point, over l_c, after which the rows are built anew.

    """

    ACTIVE = True

    def __init__(self, kernel, particles: Particles, spacing_m: float, tolerance: float = TOLERANCE):
        if not kernel.length_m > 0.0:
            raise ValueError(f"characteristic length is {kernel.length_m} m; it must be above 0")
        self.kernel, self.particles = kernel, particles
        self.radius = kernel.CUT * kernel.length_m
        self.allowed = tolerance * kernel.length_m
        self.builds, self.revision = 0, -1
        self.origin = {}  # places and volumes of the points that the rows were built from
        count = particles.count
        self.pairs_most = most_pairs(kernel, spacing_m, count)
        self.start = ti.field(ti.i32, shape=count + 2)  # one row more than points, always empty
        self.neighbour = ti.field(ti.i32, shape=self.pairs_most)
        self.share = ti.field(real, shape=self.pairs_most)
        self.norm = ti.field(real, shape=count + 1)
        self.motion = ti.field(real, shape=((count + LANES - 1) // LANES + 1, 6, LANES))
        self.place = ti.Vector.field(2, real, shape=count)

    @property
    def pairs(self) -> int:
        """Number of weights in use."""
        return int(self.start[self.particles.count])

    @ti.func
    def keep(self, lanes: ti.template(), p, D, spin, length):
        """Remember the strain rate, spin and norm of the strain rate of point or group p."""
        kept = (D[0], D[1], D[2], D[3], spin, length)
        for c in ti.static(range(6)):
            if ti.static(wide()):
                for k in ti.static(range(LANES)):
                    self.motion[p, c, k] = kept[c][k]
            else:
                self.motion[p // LANES, c, p % LANES] = kept[c]
        if ti.static(wide()):
            for k in ti.static(range(LANES)):
                self.norm[self.particles.order[p * LANES + k]] = length[k]
        else:
            self.norm[p] = length

    @ti.func
    def kept(self, lanes: ti.template(), p):
        """Strain rate (4), spin and norm of point or group p."""
        if ti.static(wide()):
            return self.row(p, 0), self.row(p, 1), self.row(p, 2), self.row(p, 3), self.row(p, 4), self.row(p, 5)
        g, k = p // LANES, p % LANES
        return (
            self.motion[g, 0, k], self.motion[g, 1, k], self.motion[g, 2, k], self.motion[g, 3, k],
            self.motion[g, 4, k], self.motion[g, 5, k],
        )  # fmt: skip

    @ti.func
    def row(self, p, c: ti.template()):
        """Value c of the eight points of a group."""
        values = eight(0.0)
        for k in ti.static(range(LANES)):
            values[k] = self.motion[p, c, k]
        return values

    @ti.func
    def mean(self, p):
        """The non-local norm of the strain rate of point p [1/s]."""
        total = 0.0
        for k in range(self.start[p], self.start[p + 1]):
            total += self.share[k] * self.norm[self.neighbour[k]]
        return total

    @ti.func
    def mean_of_group(self, g):
        """That of the eight points of a group."""
        means = eight(0.0)
        for k in ti.static(range(LANES)):
            means[k] = self.mean(self.particles.order[g * LANES + k])
        return means

    def steps_within(self, speed_m_per_s: float, dt: float) -> int:
        """How many steps it takes at this speed to use up half of the allowed displacement; at most MOST_STEPS."""
        return int(min(MOST_STEPS, max(1.0, 0.5 * self.allowed / (speed_m_per_s * dt + 1e-300))))

    def refresh(self) -> None:
        """Build the rows anew if there are none, or a point has used up half of the allowed displacement."""
        if self.revision != self.particles.revision or self._moved() > 0.5 * self.allowed:
            self.build()

    def build(self) -> None:
        """Build all rows.

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
        if start[-1] > self.pairs_most:
            raise RunFailed(
                f"because {start[-1]} pairs of neighbours exceed the room for {self.pairs_most}: points have clumped"
            )
        full = np.full(self.particles.count + 2, start[-1], dtype=np.int32)
        full[: len(start)] = start
        self.start.from_numpy(full)
        self._fill(order, first, bins.astype(np.int32), across, rows)
        self.builds += 1
        self.revision = self.particles.revision

    @ti.kernel
    def _moved(self) -> real:
        most = 0.0
        for p in range(self.particles.active[None]):
            ti.atomic_max(most, (self.particles.position[p] - self.place[p]).norm())
        return most

    @ti.kernel
    def _count(
        self, order: ti.types.ndarray(), first: ti.types.ndarray(), bins: ti.types.ndarray(), across: ti.i32,
        rows: ti.i32, length: ti.types.ndarray(),
    ):  # fmt: skip
        for p in range(self.particles.active[None]):
            here = self.particles.position[p]
            found = 0
            for row in range(ti.max(bins[p, 1] - 1, 0), ti.min(bins[p, 1] + 2, rows)):
                left = row * across + ti.max(bins[p, 0] - 1, 0)
                right = row * across + ti.min(bins[p, 0] + 2, across)
                for k in range(first[left], first[right]):
                    if (self.particles.position[order[k]] - here).norm() <= self.radius:
                        found += 1
            length[p] = found

    @ti.kernel
    def _fill(
        self, order: ti.types.ndarray(), first: ti.types.ndarray(), bins: ti.types.ndarray(), across: ti.i32,
        rows: ti.i32,
    ):  # fmt: skip
        for p in range(self.particles.active[None]):
            here = self.particles.position[p]
            self.place[p] = here
            at, total = self.start[p], 0.0
            for row in range(ti.max(bins[p, 1] - 1, 0), ti.min(bins[p, 1] + 2, rows)):
                left = row * across + ti.max(bins[p, 0] - 1, 0)
                right = row * across + ti.min(bins[p, 0] + 2, across)
                for k in range(first[left], first[right]):
                    q = order[k]
                    distance = (self.particles.position[q] - here).norm()
                    if distance <= self.radius:
                        share = self.kernel.weight(distance) * self.particles.volume[q]
                        self.neighbour[at], self.share[at] = q, share
                        at, total = at + 1, total + share
            for k in range(self.start[p], at):
                self.share[k] = self.share[k] / total
