"""A Gaussian mean over neighbours by way of a grid of its own.

A Gaussian is the product of one along x and one along y, and a convolution of narrower ones. Points give their values
to nodes with quadratic weights S, a kernel g acts between nodes along rows, then along columns, and S brings the result
back:

    d_p = c_p sum_i S_ip sum_j g_(i-j) sum_q S_jq V_q d_q,

c_p being such that a field alike everywhere stays as it is. To and fro, S is a convolution of six boxes as wide as the
spacing H of the nodes: a variance of H^2 / 2 and a fourth cumulant of -H^4 / 20 along each axis. The five numbers of g
supply what a Gaussian exp(-r^2 / l_c^2) has more, a variance of l_c^2 / 2 and a fourth cumulant of 0. With H = l_c /
1.5 all are positive, and means differ from those over rows of neighbours by less than 1 % of the largest value. The
cost is the same for any l_c.
"""

import math
from collections.abc import Sequence

import numpy as np

from taichi_silo.mpm.contracts import Kernel
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.means import Means
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real, whole_numbers

PER_LENGTH = 1.5  # nodes along a characteristic length
VARIANCE = 0.5 * (PER_LENGTH**2 - 1.0)  # of g [H^2]
FURTHEST = (3.0 * VARIANCE**2 + 0.05 - VARIANCE) / 24.0  # g of nodes two apart, from its fourth cumulant of 1/20
NEXT = 0.5 * VARIANCE - 4.0 * FURTHEST  # of neighbours
TAPS = (1.0 - 2.0 * NEXT - 2.0 * FURTHEST, NEXT, FURTHEST)
REACH = len(TAPS) - 1
RECORD = 8  # numbers of a point, so that they lie in one line of the cache
GROWTH = 1.5  # by which a grid whose height follows the sand may grow


@ti.data_oriented
class GridMeans(Means):
    """The mean through nodes l_c / 1.5 apart, over the box of the solver's grid.

    ==============  ==============  ======================================================================
    field           shape           meaning
    ==============  ==============  ======================================================================
    first           point + 1       number of the first of a point's nine nodes
    weights         point + 1, 8    S along x (3), S along y times the volume V (3), c_p / V less the share of the
                                    kernel beyond rigid planes, 0
    given           copy, node      what points gave
    convolved       node            after the pass along x
    result          node            after the pass along y
    ==============  ==============  ======================================================================

    Parameters
    ----------
    grid : of the solver, whose box is covered.
    mirrored : whether the grid's last column before its margin is an axis of symmetry (see `mirrored_solver`).
    others : see `Means`.

    """

    def __init__(
        self, kernel: Kernel, particles: Particles, grid: Grid, mirrored: bool = False,
        rigid_planes: Sequence[tuple[int, int, float]] = (), alike_along_x: bool = False,
    ):  # fmt: skip
        super().__init__(kernel, particles, rigid_planes, alike_along_x)
        self.spacing, self.mirrored = kernel.length_m / PER_LENGTH, mirrored
        self.copies, self.reach_m = 0, 3.0 * self.spacing
        margin = MARGIN * grid.cell_size / self.spacing
        width = 0.0 if alike_along_x else (grid.columns - 1 - 2 * MARGIN) * grid.cell_size / self.spacing
        height = grid.height * (1.0 if grid.follows in ("bottom", "nothing") else GROWTH) / self.spacing
        # columns and rows of the origin; the middle of a whole body, where that of a half ends, lies on nodes
        middle = width if mirrored else 0.5 * width
        self.origin_at = REACH + 1 + margin + -(margin + middle) % 1.0, REACH + 1 + margin
        self.axis = round(self.origin_at[0] + width)
        self.columns = self.axis + 3 + REACH + (0 if mirrored else math.ceil(margin) + 1)
        self.rows = math.ceil(self.origin_at[1] + height + margin) + 2 + REACH
        self.nodes = self.columns * self.rows
        (self.first,) = whole_numbers((particles.count + 1,))  # the last entry is that of no point
        self.weights = ti.field(real, shape=(particles.count + 1, RECORD))
        self.convolved, self.result = (ti.field(real, shape=self.nodes) for _ in range(2))

    def hold(self, copies: int) -> None:
        """See `Means`."""
        self.copies = copies
        self.given = ti.field(real, shape=copies * self.nodes)

    def passes(self) -> tuple:
        """Along x, and along y."""
        return self.along_row, self.along_columns

    def _build(self, place: np.ndarray) -> None:
        if not self.copies:
            self.hold(1)
        entries = self.particles.count + 1
        first, weights = np.zeros(entries, dtype=np.int32), np.zeros((entries, RECORD))
        node, parts = np.zeros((2, len(place)), dtype=np.int32), []
        for axis, most in ((0, self.columns), (1, self.rows)):
            start = self.origin_at[axis] + place[:, axis] / self.spacing - 0.5
            node[axis] = np.floor(start).clip(REACH, most - 3 - REACH)
            a = (start - node[axis]).clip(0.0, 1.0)  # of points that have left the grid the guard will tell
            parts.append(np.stack([0.5 * (1.0 - a) ** 2, 0.5 + a - a * a, 0.5 * a * a], axis=1))
        active, volume = len(place), self.origin["volume"][:, None]
        first[:active] = node[1] * self.columns + node[0]
        weights[:active, :7] = np.concatenate([parts[0], parts[1] * volume, 1.0 / volume], axis=1)
        put(self.first, first)
        put(self.weights, weights)
        self._normalise()

    @ti.func
    def give(self, store: ti.template(), p, value, copy):
        """Hand in the value of point number p."""
        k = copy * self.nodes + self.first[p]
        for b in ti.static(range(3)):
            of_row = value * self.weights[p, 3 + b]
            for a in ti.static(range(3)):
                store.add(self.given, k + b * self.columns + a, of_row * self.weights[p, a])

    @ti.func
    def mean(self, p):
        """The mean around point number p."""
        k, total = self.first[p], ti.cast(0.0, real)
        for b in ti.static(range(3)):
            of_row = ti.cast(0.0, real)
            for a in ti.static(range(3)):
                of_row += self.result[k + b * self.columns + a] * self.weights[p, a]
            total += of_row * self.weights[p, 3 + b]
        return total * self.weights[p, 6]

    @ti.func
    def along_row(self, j):
        """The pass along x over row j of what points gave, which is emptied."""
        start = j * self.columns
        if ti.static(self.mirrored):  # nodes beyond the axis are images
            self.given[start + self.axis] = 2.0 * self.taken(start + self.axis)
            for n in ti.static(range(1, 2 + REACH)):
                both = self.taken(start + self.axis - n) + self.taken(start + self.axis + n)
                self.given[start + self.axis - n], self.given[start + self.axis + n] = both, both
        nothing = ti.cast(0.0, real)
        a, b, c, d = nothing, nothing, nothing, self.taken(start)
        for k in range(start + 1, start + self.columns):
            e = self.taken(k)
            self.convolved[k - REACH] = TAPS[0] * c + TAPS[1] * (b + d) + TAPS[2] * (a + e)
            a, b, c, d = b, c, d, e

    @ti.func
    def taken(self, k):
        """What all points gave to node k, which is emptied."""
        total = self.given[k]
        self.given[k] = 0.0
        for copy in ti.static(range(1, self.copies)):
            total = total + self.given[copy * self.nodes + k]
            self.given[copy * self.nodes + k] = 0.0
        return total

    @ti.func
    def along_columns(self, j):
        """The pass along y, for the nodes of row j."""
        if j >= REACH and j < self.rows - REACH:
            up = ti.static(self.columns)
            for k in range(j * self.columns, (j + 1) * self.columns):
                beside = self.convolved[k - up] + self.convolved[k + up]
                further = self.convolved[k - 2 * up] + self.convolved[k + 2 * up]
                self.result[k] = TAPS[0] * self.convolved[k] + TAPS[1] * beside + TAPS[2] * further

    @ti.kernel
    def _normalise(self):
        ti.loop_config(serialize=self.serial)
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            self.give(self, p, ti.cast(1.0, real), 0)
        ti.loop_config(serialize=self.serial)
        for j in range(self.rows):
            self.along_row(j)
        ti.loop_config(serialize=self.serial)
        for j in range(self.rows):
            self.along_columns(j)
        ti.loop_config(serialize=self.serial)
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            self.weights[p, 6] = self.weights[p, 6] * self.sand[p] / (self.mean(p) + 1e-300)
