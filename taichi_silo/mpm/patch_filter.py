"""A filter of the points' stresses that acts by strain: what varies from cell to cell fades as the sand is sheared.

Nodes feel sum_p V_p sigma_p grad S_ip alone. Patterns of stress that this sum does not feel, of points within a cell or
of cells in turn, are held by the law's memory only, and sheared sand has little of it: near the critical state its
pressure follows from the void ratio, of which a few thousandths are the whole pressure. Left alone they grow until
every second point carries twice the mean stress and the others none.

Let P take stresses to the nodes with quadratic weights, volume-weighted means at the centroids of what they are means
of, and back with the slope that they have there. P leaves linear fields as they are, at walls, free surfaces and
between scattered points too, and takes out what alternates between points of a cell, or between cells. The filter
subtracts a share of what four passes of 1 - P leave,

    sigma_p <- sigma_p - (1 - exp(-gamma_p / STRAIN)) [(1 - P)^4 sigma]_p

where gamma_p is the path length of the point's strain since the filter's last turn. Nothing happens to sand at rest or
to a body that only moves, and the error is of eighth order in the cell size. What P does not know at all fades as
exp(-gamma / STRAIN) whatever the turns; what it half knows fades the more, the more turns share a strain, so turns
follow each other by the way of the points (`TURN`), whatever the time step.
"""

import contextlib

import numpy as np
import taichi as ti

from taichi_silo.mpm import runtime
from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.executors import Phase
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.shapes.ugimp import UniformGimp
from taichi_silo.mpm.simd import selftest
from taichi_silo.mpm.simd.lane_maths import exp_minus
from taichi_silo.mpm.simd.vectors import arrays_of_eight, compiling_simd, eight

PASSES = 4
STRAIN = 3e-4  # over which a pattern falls to 1 / e
TURN = 3e-3  # of a cell: way of the fastest point between two turns of the filter
MOST_STEPS = 2000  # between them
FINITE = 1e30  # a larger stress [Pa] is none
LEAST_SPREAD = 0.03  # of centroids around a point along an axis [cells], below which they show no slope along it
STRIPS = 2  # of points, each with sums of its own, so that their order does not depend on the threads
STRESS = (1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0)  # slots of the residual
MIRROR = (1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0)  # of the eight slots of a node: x turns round


@ti.data_oriented
class PatchFilter:
    """The filter, over patches of three nodes an axis.

    Parameters
    ----------
    particles, grid, law : of the solver.
    mirrored : whether the grid's last column before its margin is an axis of symmetry (see `mirrored_solver`).

    ==============  ==============  ======================================================================
    array of eight  shape           meaning
    ==============  ==============  ======================================================================
    points          point * 2       residual of the stress (4); weight (volume, 0 where something is not finite),
                                    place, vector to it from where the means around it are right [cells]
    sums            strip * node    what the points of a strip gave: weight times residual (4); at first also
                                    weight and its moments about the node [cells]
    means           node            of the residual (4)
    centres         node            1 / weight, 0 (3), weight, centroid from the node [cells]
    ==============  ==============  ======================================================================

    """

    ACTIVE = True
    BETWEEN_LAUNCHES = True

    def __init__(self, particles: Particles, grid: Grid, law: Law, mirrored: bool = False):
        self.particles, self.grid, self.law, self.mirrored = particles, grid, law, mirrored
        self.weights = UniformGimp(0.5)
        self.path = ti.field(real, shape=particles.count)  # of the strain at the last turn
        self.revision, self.way, self.steps = -1, 0.0, 0  # of the points; way [cells] and steps since the last turn
        self.shared = not runtime.is_cpu()
        self.strips = 1 if self.shared else STRIPS
        self.points = runtime.array(eight, 2 * particles.count)
        self.sums = runtime.array(eight, self.strips * grid.nodes)
        self.means, self.centres = runtime.array(eight, grid.nodes), runtime.array(eight, grid.nodes)
        self.sums.fill(0.0)
        self.compiled = False

    def phases(self) -> list[Phase]:
        """None: it acts between launches."""
        return []

    def begin(self) -> None:
        """Count the strain of each point from now on, if the points are others than before."""
        if self.revision != self.particles.revision:
            self.revision, self.way, self.steps = self.particles.revision, 0.0, 0
            self._note_paths()

    def keep(self, stayed: np.ndarray) -> None:
        """Go on with those of the points (bool) that have stayed; the others have just been taken out."""
        if self.revision == self.particles.revision - 1:
            self.revision = self.particles.revision
            path = np.zeros(self.particles.count)
            path[: stayed.sum()] = self.path.to_numpy()[: len(stayed)][stayed]
            self.path.from_numpy(path)

    def steps_within(self, speed_m_per_s: float, dt: float) -> int:
        """How many steps at this speed may pass before the next turn."""
        way = speed_m_per_s * dt / self.grid.cell_size
        return max(1, int(min(MOST_STEPS - self.steps, (TURN - self.way) / (way + 1e-300) + 1e-6)))

    def passed(self, steps: int, speed_m_per_s: float, dt: float) -> None:
        """So many steps have passed; a turn if it is due."""
        self.steps += steps
        self.way += steps * speed_m_per_s * dt / self.grid.cell_size
        next_way = speed_m_per_s * dt / self.grid.cell_size
        if self.steps >= MOST_STEPS or self.way + next_way > TURN * (1.0 + 1e-6):
            self.turn()
            self.way, self.steps = 0.0, 0

    def state(self) -> dict:
        """What outlives a launch, for a checkpoint."""
        return {"path": self.path.to_numpy(), "way": self.way, "steps": self.steps}

    def restore(self, state: dict) -> None:
        """Go on from the points that are there now, and from what `state` gave."""
        self.path.from_numpy(state["path"])
        self.revision, self.way, self.steps = self.particles.revision, state["way"], state["steps"]

    def turn(self) -> None:
        """Let fade what is to fade."""
        self._read(self.points)
        vectors = not self.shared and real == ti.f64 and not selftest.failure()
        with compiling_simd() if vectors and not self.compiled else contextlib.nullcontext():
            self._pass(self.points, self.sums, self.means, self.centres)
        self.compiled = True
        self._fade(self.points)

    # --- fields, whose components cannot be had where vectors stay vectors of the processor ------------------------

    @ti.kernel
    def _note_paths(self):
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            self.path[p] = self.particles.path[p]

    @ti.kernel
    def _read(self, points: arrays_of_eight):
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            s, weight = self.particles.stress[p], self.particles.volume[p]
            x = self.particles.position[p][0] / self.grid.cell_size
            y = self.particles.position[p][1] / self.grid.cell_height(0)
            if not ti.abs(s).sum() + ti.abs(x) + ti.abs(y) < FINITE:
                s, weight, x, y = ti.Vector([0.0, 0.0, 0.0, 0.0]), 0.0, 0.0, 0.0
            points[2 * p] = eight(s[0], s[1], s[2], s[3], 0.0, 0.0, 0.0, 0.0)
            points[2 * p + 1] = eight(weight, x, y, 0.0, 0.0, 0.0, 0.0, 0.0)

    @ti.kernel
    def _fade(self, points: arrays_of_eight):
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            share = 1.0 - exp_minus((self.particles.path[p] - self.path[p]) / STRAIN)
            self.path[p] = self.particles.path[p]
            if points[2 * p + 1][0] > 0.0:
                s, left = self.particles.stress[p], points[2 * p]
                e = self.particles.volume[p] * self.law.grain_density / self.particles.mass[p] - 1.0
                faded = s[0] - share * left[0], s[1] - share * left[1], s[2] - share * left[2], s[3] - share * left[3]
                self.particles.write("stress", p, self.law.admissible(faded, e))

    # --- passes -----------------------------------------------------------------------------------------------------

    @ti.kernel
    def _pass(
        self, points: arrays_of_eight, sums: arrays_of_eight, means: arrays_of_eight, centres: arrays_of_eight
    ):  # fmt: skip
        # pass 0 gives the stresses to the nodes, each later one what the one before it has left of them
        for number in ti.static(range(PASSES + 1)):
            if ti.static(self.shared):
                for p in range(self.particles.places()):
                    if not self.particles.is_there(p):
                        continue
                    self._point(number, points, sums, means, centres, 0, p)
            else:
                ti.loop_config(block_dim=1)
                for strip in range(self.strips):
                    for p in range(self._first(strip), self._first(strip + 1)):
                        self._point(number, points, sums, means, centres, strip, p)
            if ti.static(number < PASSES and self.mirrored):
                for j in range(self.grid.rows):
                    self._fold(sums, j)
            if ti.static(number < PASSES):
                for k in range(self.grid.nodes):
                    self._take_means(number, sums, means, centres, k)

    @ti.func
    def _first(self, strip):
        """Number of the first point of a strip."""
        return strip * self.particles.active[None] // self.strips

    @ti.func
    def _point(
        self, number: ti.template(), points: ti.template(), sums: ti.template(), means: ti.template(),
        centres: ti.template(), strip, p,
    ):  # fmt: skip
        """Point p's part of a pass."""
        known, left = points[2 * p + 1], points[2 * p]
        i, sx, gx, j, sy, gy = self._patch(known[1], known[2])
        from_x, from_y = known[1] - (i - MARGIN), known[2] - (j - MARGIN)
        if ti.static(number == 0):
            given = left + eight(0.0, 0.0, 0.0, 0.0, 1.0, from_x, from_y, 0.0)
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    offset = eight(*ti.static((0.0, 0.0, 0.0, 0.0, 0.0, float(a), float(b), 0.0)))
                    self._add(sums, strip, i + a, j + b, eight(known[0] * sx[a] * sy[b]) * (given - offset))
        else:
            tx, ty = known[3], known[4]
            if ti.static(number == 1):
                tx, ty = self._vector_to_point(centres, from_x, from_y, i, sx, gx, j, sy, gy)
                points[2 * p + 1] = eight(known[0], known[1], known[2], tx, ty, 0.0, 0.0, 0.0)
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    share = sx[a] * sy[b] - tx * gx[a] * sy[b] - ty * sx[a] * gy[b]
                    left = left - eight(share) * means[self.grid.node(i + a, j + b)]
            points[2 * p] = left
            if ti.static(number < PASSES):
                for b in ti.static(range(3)):
                    for a in ti.static(range(3)):
                        self._add(sums, strip, i + a, j + b, eight(known[0] * sx[a] * sy[b]) * left)

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
    def _vector_to_point(self, centres: ti.template(), from_x, from_y, i, sx, gx, j, sy, gy):
        """The vector to a point from where the means around it are right, so that they find a linear field exactly.

        The sum of s_i m_i is the field at the centroid of the centroids; its slope (d/dx, d/dy) follows from the sums
        of m_i grad s_i, which are `spread` times that slope.
        """
        offset_x, offset_y, xx, xy, yx, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # and the spread
        for b in ti.static(range(3)):
            for a in ti.static(range(3)):
                centre = centres[self.grid.node(i + a, j + b)]
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
    def _add(self, sums: ti.template(), strip, i, j, value):
        """To the sums of a strip at node (i, j)."""
        k = strip * self.grid.nodes + self.grid.node(i, j)
        if ti.static(self.shared):
            sums[k] += value
        else:
            sums[k] = sums[k] + value

    @ti.func
    def _take_means(
        self, number: ti.template(), sums: ti.template(), means: ti.template(), centres: ti.template(), k
    ):  # fmt: skip
        """Mean of the residual at node k, and at first the weight and its centroid; the sums are emptied."""
        total = eight(0.0)
        for strip in ti.static(range(self.strips)):
            total = total + sums[strip * self.grid.nodes + k]
            sums[strip * self.grid.nodes + k] = eight(0.0)
        centre = centres[k]
        if ti.static(number == 0):
            weight = total[4]
            per_weight = ti.select(weight > 0.0, 1.0 / ti.max(weight, 1e-300), 0.0)
            centre = eight(per_weight, 0.0, 0.0, 0.0, weight, total[5] * per_weight, total[6] * per_weight, 0.0)
            centres[k] = centre
        means[k] = eight(centre[0]) * eight(*ti.static(STRESS)) * total

    @ti.func
    def _fold(self, sums: ti.template(), j):
        """What the points' mirror images beyond the axis give as well, in row j."""
        axis = self.grid.node(self.grid.columns - 1 - MARGIN, j)
        for strip in ti.static(range(self.strips)):
            for n in ti.static(range(MARGIN + 1)):
                here, there = strip * self.grid.nodes + axis - n, strip * self.grid.nodes + axis + n
                total = sums[here] + eight(*ti.static(MIRROR)) * sums[there]
                sums[here], sums[there] = total, eight(*ti.static(MIRROR)) * total
