"""What a filter of stresses takes out: the passes of (1 - P) between points and patches of three nodes an axis.

P takes stresses to the nodes as means, and back to the points (see `patch_filter`).
"""

import contextlib
from typing import Any

from taichi_silo.mpm import runtime
from taichi_silo.mpm.cell_lists import CellLists
from taichi_silo.mpm.executors import Barrier
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.one_node import chosen
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.shapes.ugimp import UniformGimp
from taichi_silo.mpm.simd import selftest
from taichi_silo.mpm.simd.store import STRIPS
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight, compiling_simd, eight

PASSES = 4
LEAST_SPREAD = 0.03  # of centroids around a point along an axis [cells], below which they show no slope along it
TURNS = 2  # in which strips of points add to nodes
STRESS = (1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0)  # slots of the residual
PLACE = (0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0)  # and of what else a point has
NOWHERE = -1e6  # row at which a point stands of which something is not finite; it has no weight
MIRROR = (1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0)  # of the eight slots of a node: x turns round


@ti.data_oriented
class PatchPasses:
    """The passes, and the arrays that they work on.

    Parameters
    ----------
    particles, grid : of the solver.
    mirrored : whether the grid's last column before its margin is an axis of symmetry (see `mirrored_solver`).

    ==============  ==============  ======================================================================
    array of eight  shape           meaning
    ==============  ==============  ======================================================================
    points          point           residual of the stress (4), place, vector to it from where the means around it
                                    are right [cells]; its weight is its volume
    sums            node            what points gave: weight times residual (4); at first also weight and its
                                    moments about the node [cells]
    means           node            of the residual (4), 1 / weight (0 without any), centroid from the node [cells], 0
    ==============  ==============  ======================================================================

    Threads share the strips of the vector unit (`simd.store.Layout`), in two turns, so that the order of sums does not
    depend on their number; on plain loops one thread does all.

    """

    def __init__(self, particles: Particles, grid: Grid, mirrored: bool):
        self.particles, self.grid, self.mirrored = particles, grid, mirrored
        self.weights = UniformGimp(0.5)
        self.shared = not runtime.is_cpu()
        self.threads, self.alone = runtime.threads(), runtime.alone()
        self.barrier = Barrier(self.threads)
        self.layout: Any = None  # of the vector unit, if it has lent its arrays
        self.lists: Any = CellLists(particles, grid, self.weights) if self.shared else None
        self.points: Any = None
        self.sums: Any = None
        self.means: Any = None
        self.compiled = False

    def hold(self) -> None:
        """Have the arrays, if the step has not lent its own."""
        if self.points is None:
            self.points = runtime.array(eight, self.particles.count)
            self.sums, self.means = (runtime.array(eight, self.grid.nodes) for _ in range(2))

    def run(self) -> None:
        """Leave in `points` what the passes leave of the stresses that stand there."""
        arrays = self.points, self.sums, self.means
        if self.shared:
            self.lists.fill(0)
            self._pass_on_tasks(*arrays)
            return
        vectors = real == ti.f64 and not selftest.failure()
        with compiling_simd() if vectors and not self.compiled else contextlib.nullcontext():
            self._pass(*arrays, self.barrier.reserve((PASSES + 1) * (TURNS + 1)))
        self.compiled = True

    # pass 0 gives the stresses to the nodes, each later one what the one before it has left of them

    @ti.kernel
    def _pass(self, points: arrays_of_eight, sums: arrays_of_eight, means: arrays_of_eight, passed: ti.i32):
        ti.loop_config(block_dim=1, serialize=self.alone)
        for t in range(self.threads):
            for kind, times in ti.static(enumerate((1, 1, PASSES - 1))):  # from the third on they are alike
                for again in range(times):
                    number = kind + again
                    waits = number * (TURNS + 1)
                    for turn in range(TURNS):
                        self.barrier.wait(passed, waits + turn)
                        self._points_of_turn(kind, points, sums, means, t, turn, number < PASSES)
                    self.barrier.wait(passed, waits + TURNS)
                    if number < PASSES:
                        for j in range(t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads):
                            if ti.static(self.mirrored):
                                fold(self.grid, sums, j)
                            for k in range(j * self.grid.columns, (j + 1) * self.grid.columns):
                                self._take_means(kind, sums, means, k)

    @ti.func
    def _points_of_turn(
        self, kind: ti.template(), points: ti.template(), sums: ti.template(), means: ti.template(), t, turn, gives
    ):  # fmt: skip
        """A pass for those points of thread t whose turn it is."""
        active = self.particles.active[None]
        if ti.static(not self.layout):
            if t == 0 and turn == 0:
                for p in range(active):
                    self._point(kind, points, sums, means, p, kind > 0, True, gives, 0, 0)
        else:
            for strip in range(t * STRIPS // self.threads, (t + 1) * STRIPS // self.threads):
                if self.layout.half[strip] == turn:
                    for q in range(LANES * self.layout.first[strip], LANES * self.layout.first[strip + 1]):
                        if self.layout.order[q] < active:
                            self._point(
                                kind, points, sums, means, self.layout.order[q], kind > 0, True, gives, 0, 0
                            )  # fmt: skip

    @ti.kernel
    def _pass_on_tasks(
        self, points: arrays_of_eight, sums: arrays_of_eight, means: arrays_of_eight
    ):  # fmt: skip
        for number in ti.static(range(PASSES + 1)):
            if ti.static(number > 0):
                for p in range(self.particles.count):
                    if self.particles.is_there(p):
                        self._point(number, points, sums, means, p, True, False, False, 0, 0)
            if ti.static(number < PASSES):
                for k in range(self.grid.nodes):
                    i, j = k % self.grid.columns, k // self.grid.columns
                    for given in ti.static([Given(self, number, points, sums, means, i, j)]):
                        self.lists.ask(given, 0, i, j, 0)
                    if ti.static(not self.mirrored):
                        self._take_means(number, sums, means, k)
            if ti.static(number < PASSES and self.mirrored):
                for j in range(self.grid.rows):
                    fold(self.grid, sums, j)
                for k in range(self.grid.nodes):
                    self._take_means(number, sums, means, k)

    @ti.func
    def _point(
        self, number: ti.template(), points: ti.template(), sums: ti.template(), means: ti.template(),
        p, subtracts: ti.template(), gives: ti.template(), now, column, row,
    ):  # fmt: skip
        """Point p's part of a pass: it subtracts the means from what it has left, and gives that to the nodes.

        It gives if that is compiled and wanted `now`; on tasks only to the node in a column and a row (see `one_node`).
        """
        known = points[p]
        left, weight = eight(*ti.static(STRESS)) * known, self._weight(p, known[5])
        i, sx, gx, j, sy, gy = self._patch(known[4], known[5])
        from_x, from_y = known[4] - (i - MARGIN), known[5] - (j - MARGIN)
        if ti.static(subtracts):
            tx, ty = known[6], known[7]
            if ti.static(number == 1):
                tx, ty = self._vector_to_point(means, from_x, from_y, i, sx, gx, j, sy, gy)
                known = known + eight(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, tx, ty)
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    share = sx[a] * sy[b] - tx * gx[a] * sy[b] - ty * sx[a] * gy[b]
                    left = left - eight(share) * means[self.grid.node(i + a, j + b)]
            left = eight(*ti.static(STRESS)) * left
            points[p] = left + eight(*ti.static(PLACE)) * known
        if ti.static(gives):  # noqa: SIM102 (compiled in or not)
            if now:
                self._give(number, sums, left, weight, from_x, from_y, i, sx, j, sy, column, row)

    @ti.func
    def _give(
        self, number: ti.template(), sums: ti.template(), left, weight, from_x, from_y, i, sx, j, sy, column, row
    ):  # fmt: skip
        """What a point has left, to its nodes."""
        given = left
        if ti.static(number == 0):
            given = left + eight(0.0, 0.0, 0.0, 0.0, 1.0, from_x, from_y, 0.0)
        if ti.static(self.shared):
            a, b = column - i, row - j
            if ti.static(self.grid.periodic):
                a = a % self.grid.columns
            offset = eight(0.0, 0.0, 0.0, 0.0, 0.0, ti.cast(a, real), ti.cast(b, real), 0.0)
            of_node = given - offset if ti.static(number == 0) else given
            k = self.grid.node(i + a, j + b)
            sums[k] = sums[k] + eight(weight * chosen(sx, a) * chosen(sy, b)) * of_node
        else:
            for y in ti.static(range(3)):
                for x in ti.static(range(3)):
                    offset = eight(*ti.static((0.0, 0.0, 0.0, 0.0, 0.0, float(x), float(y), 0.0)))
                    of_node = given - offset if ti.static(number == 0) else given
                    k = self.grid.node(i + x, j + y)
                    sums[k] = sums[k] + eight(weight * sx[x] * sy[y]) * of_node

    @ti.func
    def _weight(self, p, row):
        """Of point p, whose place is a row [cells]."""
        weight = self.particles.volume[p]
        if row <= NOWHERE:
            weight = 0.0
        return weight

    @ti.func
    def _patch(self, x, y):
        """First column, weights and slopes along x, first row, the same along y, of nodes around a place [cells]."""
        i, sx, gx, j, sy, gy = self.weights.patch(0, x, y, (0.0, 0.0, 0.0, 0.0))
        column, row = ti.cast(i, ti.i32) + MARGIN, ti.cast(j, ti.i32) + MARGIN
        # a point that has left the grid (the guard will stop the run) must not write outside it
        if ti.static(not self.grid.periodic):
            column = ti.max(0, ti.min(column, self.grid.columns - 3))
        return column, sx, gx, ti.max(0, ti.min(row, self.grid.rows - 3)), sy, gy

    @ti.func
    def _vector_to_point(self, means: ti.template(), from_x, from_y, i, sx, gx, j, sy, gy):
        """The vector to a point from where the means around it are right, so that they find a linear field exactly.

        The sum of s_i m_i is the field at the centroid of the centroids; its slope (d/dx, d/dy) follows from the sums
        of m_i grad s_i, which are `spread` times that slope.
        """
        offset_x, offset_y, xx, xy, yx, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # and the spread
        for b in ti.static(range(3)):
            for a in ti.static(range(3)):
                centre = means[self.grid.node(i + a, j + b)]
                if centre[4] > 0.0:
                    cx, cy = centre[5] + a - from_x, centre[6] + b - from_y
                    s, dx, dy = sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]
                    offset_x, offset_y = offset_x + s * cx, offset_y + s * cy
                    xx, xy, yx, yy = xx + dx * cx, xy + dx * cy, yx + dy * cx, yy + dy * cy
        tx, ty, area = 0.0, 0.0, xx * yy - xy * yx
        if area > LEAST_SPREAD * LEAST_SPREAD:
            tx, ty = (yy * offset_x - yx * offset_y) / area, (xx * offset_y - xy * offset_x) / area
        else:  # a strand
            if xx > LEAST_SPREAD:
                tx = offset_x / xx
            if yy > LEAST_SPREAD:
                ty = offset_y / yy
        return tx, ty

    @ti.func
    def _take_means(self, number: ti.template(), sums: ti.template(), means: ti.template(), k):
        """Mean of the residual at node k, and at first the weight and its centroid; the sums are emptied."""
        total = sums[k]
        sums[k] = eight(0.0)
        centre = eight(*ti.static(PLACE)) * means[k]
        if ti.static(number == 0):
            weight = total[4]
            per_weight = ti.select(weight > 0.0, 1.0 / ti.max(weight, 1e-300), 0.0)
            centre = eight(0.0, 0.0, 0.0, 0.0, per_weight, total[5] * per_weight, total[6] * per_weight, 0.0)
        means[k] = eight(centre[4]) * eight(*ti.static(STRESS)) * total + centre


@ti.func
def fold(grid: ti.template(), sums: ti.template(), j):
    """What the points' mirror images beyond the axis give as well, in row j."""
    axis = grid.node(grid.columns - 1 - MARGIN, j)
    for n in ti.static(range(MARGIN + 1)):
        total = sums[axis - n] + eight(*ti.static(MIRROR)) * sums[axis + n]
        sums[axis - n], sums[axis + n] = total, eight(*ti.static(MIRROR)) * total


@ti.data_oriented
class Given:
    """What points give to node (i, j) in a pass (see `CellLists.ask`)."""

    def __init__(self, passes: PatchPasses, number: int, points: Any, sums: Any, means: Any, i: Any, j: Any):
        self.passes, self.number, self.i, self.j = passes, number, i, j
        self.points, self.sums, self.means = points, sums, means

    @ti.func
    def visit(self, p):
        """Take what point p gives."""
        self.passes._point(
            self.number, self.points, self.sums, self.means, p, False, True, True, self.i, self.j
        )  # fmt: skip
