"""The non-local norm of the strain rate: a weighted mean of ||D|| over the neighbours of a point.

    d_bar(x) = sum_q w(|x - x_q|) V_q ||D_q|| / sum_q w(|x - x_q|) V_q

The sum runs over the points that exist, so that a homogeneous field stays as it is next to a wall or a free surface.
Rigid planes may count as well: a wall of no slip as grains that do not strain.
It is summed over rows of neighbours (`neighbour_rows`, the reference), or, a Gaussian, by way of a grid (`grid_means`).
A new weight is a subclass of `Weight`, or has its members, and a name in `WEIGHTS`.
"""

import math
from collections.abc import Sequence

import numpy as np

from taichi_silo.mpm.executors import ROWS, Phase
from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.grid_means import GridMeans
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.means import Means
from taichi_silo.mpm.neighbour_rows import NeighbourRows
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.lane_maths import exp_minus

TOLERANCE = 0.02  # of l_c: no point should move so far on the same rows; from half of it on they are built anew
MOST_STEPS = 500  # between two looks at how far points have moved
GRID_FROM = 1.5  # l_c over the points' spacing, from which the grid is faster than rows
INACTIVE_FROM = 0.99  # share of a point's own weight from which averaging changes nothing


@frozen
class Weight:
    """exp(-(r / l_c)^POWER), cut off at CUT l_c, where it is 1e-4."""

    length_m: float

    POWER = 2
    CUT = 3.0

    @property
    def radius(self) -> float:
        """Beyond which there are no neighbours [m]."""
        return self.CUT * self.length_m

    @ti.func
    def weight(self, distance):
        """Of a neighbour, before normalisation."""
        return exp_minus((distance / self.length_m) ** self.POWER)


class Gaussian(Weight):
    """exp(-(r / l_c)^2) within 3 l_c: what the paper's authors computed with."""

    def beyond(self, distance_m: float) -> float:
        """Share of the weight beyond a plane at a distance."""
        return 0.5 * math.erfc(distance_m / self.length_m)


class Exponential(Weight):
    """exp(-r / l_c), as printed in the paper's equation 2."""

    POWER = 1
    CUT = 9.0


WEIGHTS = {"gaussian": Gaussian, "exponential": Exponential}


class Local:
    """No averaging: d_bar = ||D||."""

    ACTIVE = False
    KEPT = 0
    reach_m = 0.0

    def hold(self, copies: int) -> None:
        """Nothing."""


def summed_by(kernel: Weight, spacing_m: float) -> str:
    """Which means are faster for points so far apart: over a "grid", or over "rows" of neighbours."""
    return "grid" if isinstance(kernel, Gaussian) and kernel.length_m > GRID_FROM * spacing_m else "rows"


def self_weight(kernel: Weight, spacing_m: float) -> float:
    """Share of a point's own weight on a square lattice; near 1 the average is local (Python scope)."""
    reach = math.floor(kernel.CUT * kernel.length_m / spacing_m)
    along = np.arange(-reach, reach + 1) * spacing_m
    distance = np.hypot(*np.meshgrid(along, along))
    distance = distance[distance <= kernel.CUT * kernel.length_m]
    return float(1.0 / np.exp(-((distance / kernel.length_m) ** kernel.POWER)).sum())


@ti.data_oriented
class NonLocal:
    """The average by `means`, which are kept until a point has moved 0.01 to 0.02 l_c.

    `rates` are six fields (point) of the present step for stores that keep them there: strain rate (4), spin and norm
    ||D|| of each point [1/s].

    Parameters
    ----------
    kernel : of `WEIGHTS`, with its length.
    particles : the points.
    spacing_m : of the points at the start.
    tolerance : displacement of a point, over l_c, after which the means are built anew.
    rigid_planes, alike_along_x : see `Means`.
    grid, mirrored : of the solver (see `GridMeans`); without a grid means are summed over rows.
    by : whether they are summed over "rows", or by the "grid"; None: the faster one.

    """

    ACTIVE = True
    KEPT = 6  # numbers of a point that wait for the neighbours'

    def __init__(
        self, kernel: Weight, particles: Particles, spacing_m: float, tolerance: float = TOLERANCE,
        rigid_planes: Sequence[tuple[int, int, float]] = (), alike_along_x: bool = False, grid: Grid | None = None,
        mirrored: bool = False, by: str | None = None,
    ):  # fmt: skip
        self.means: Means
        if grid and (by or summed_by(kernel, spacing_m)) == "grid":
            self.means = GridMeans(kernel, particles, grid, mirrored, rigid_planes, alike_along_x)
        else:
            self.means = NeighbourRows(kernel, particles, spacing_m, rigid_planes, alike_along_x)
        self.reach_m = self.means.reach_m
        self.allowed = tolerance * kernel.length_m
        self.rates = tuple(ti.field(real, shape=particles.count) for _ in range(self.KEPT))

    def hold(self, copies: int) -> None:
        """See `Means`."""
        self.means.hold(copies)

    def phases(self) -> list[Phase]:
        """What runs between `keep` of all points and `mean`."""
        return [Phase(ROWS, self._pass, run, rows=self.means.rows) for run in self.means.passes()]

    @ti.func
    def _pass(self, store: ti.template(), j, step, run: ti.template()):
        """A pass of the means."""
        run(j)

    @ti.func
    def keep(self, store: ti.template(), p, t, D, spin, length):
        """Keep strain rate, spin and norm of the strain rate of point p, and hand the norm to the neighbours."""
        store.keep(self.rates, p, (D[0], D[1], D[2], D[3], spin, length))
        store.hand(self.means.give, p, t, length)

    @ti.func
    def kept(self, store: ti.template(), p):
        """Strain rate (4), spin and norm of point p."""
        return store.kept(self.rates, p)

    @ti.func
    def mean(self, store: ti.template(), p):
        """The non-local norm of the strain rate of point p [1/s]."""
        return store.each(self.means.mean, p)

    def steps_within(self, speed_m_per_s: float, dt: float) -> int:
        """How many steps it takes at this speed to use up half of the allowed displacement; at most MOST_STEPS."""
        return int(min(MOST_STEPS, max(1.0, 0.5 * self.allowed / (speed_m_per_s * dt + 1e-300))))

    def refresh(self) -> None:
        """Build the means anew if there are none, or a point has used up half of the allowed displacement."""
        self.means.update(0.5 * self.allowed)
