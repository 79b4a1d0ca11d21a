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

import taichi as ti

from taichi_silo.mpm import runtime
from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.executors import Phase
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.shapes.ugimp import UniformGimp

PASSES = 4
STRAIN = 3e-4  # over which a pattern falls to 1 / e
TURN = 3e-3  # of a cell: way of the fastest point between two turns of the filter
MOST_STEPS = 2000  # between them
FINITE = 1e30  # a larger stress [Pa] is none
LEAST_SPREAD = 0.03  # of centroids around a point along an axis [cells], below which they show no slope along it


@ti.data_oriented
class PatchFilter:
    """The filter, over patches of three nodes an axis.

    Parameters
    ----------
    particles, grid, law : of the solver.
    mirrored : whether the grid's last column before its margin is an axis of symmetry (see `mirrored_solver`).

    """

    ACTIVE = True
    BETWEEN_LAUNCHES = True

    def __init__(self, particles: Particles, grid: Grid, law: Law, mirrored: bool = False):
        self.particles, self.grid, self.law, self.mirrored = particles, grid, law, mirrored
        self.weights = UniformGimp(0.5)
        self.path = ti.field(real, shape=particles.count)  # of the strain at the last turn
        self.revision, self.way, self.steps = -1, 0.0, 0  # of the points; way [cells] and steps since the last turn
        self.weight = ti.field(real, shape=particles.count)  # volume, 0 where a stress is not finite
        self.residual = ti.Vector.field(4, real, shape=particles.count)
        self.volume = ti.Vector.field(3, real, shape=grid.nodes)  # and its moments about the node [cells]
        self.sums = ti.Vector.field(4, real, shape=grid.nodes)  # volume times residual, then its mean
        self.back = ti.Vector.field(9, real, shape=particles.count)  # weights of the nodes' means at a point

    def phases(self) -> list[Phase]:
        """None: it acts between launches."""
        return []

    def begin(self) -> None:
        """Count the strain of each point from now on, if the points are others than before."""
        if self.revision != self.particles.revision:
            self.revision, self.way, self.steps = self.particles.revision, 0.0, 0
            self._note_paths()

    def steps_within(self, speed_m_per_s: float, dt: float) -> int:
        """How many steps at this speed may pass before the next turn."""
        way = speed_m_per_s * dt / self.grid.cell_size
        return int(max(1.0, min(MOST_STEPS - self.steps, (TURN - self.way) / (way + 1e-300))))

    def passed(self, steps: int, speed_m_per_s: float, dt: float) -> None:
        """So many steps have passed; a turn if it is due."""
        self.steps += steps
        self.way += steps * speed_m_per_s * dt / self.grid.cell_size
        if self.steps_within(speed_m_per_s, dt) == 1:
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
        self._begin_turn()
        for _ in range(PASSES):
            self._collect()
            self._subtract_patch_means()
        self._fade()

    @ti.kernel
    def _note_paths(self):
        for p in range(self.particles.active[None]):
            self.path[p] = self.particles.path[p]

    @ti.func
    def _patch(self, p):
        """First column, weights and slopes along x, first row, the same along y, of the nodes around point p."""
        x, y = self._cells(p)
        i, sx, gx, j, sy, gy = self.weights.patch(0, x, y, (0.0, 0.0, 0.0, 0.0))
        column, row = ti.cast(i, ti.i32) + MARGIN, ti.cast(j, ti.i32) + MARGIN
        # a point that has left the grid (the guard will stop the run) must not write outside it
        if ti.static(not self.grid.periodic):
            column = ti.max(0, ti.min(column, self.grid.columns - 3))
        return column, sx, gx, ti.max(0, ti.min(row, self.grid.rows - 3)), sy, gy

    @ti.func
    def _cells(self, p):
        """Place of point p [cells]."""
        return self.particles.position[p][0] / self.grid.cell_size, self.particles.position[p][
            1
        ] / self.grid.cell_height(0)

    @ti.func
    def _add(self, sums: ti.template(), k, value):
        if ti.static(runtime.is_cpu()):
            sums[k] = sums[k] + value
        else:
            sums[k] += value

    @ti.kernel
    def _begin_turn(self):
        """Volumes of the nodes and their moments; weights on the way back; residual: the stress."""
        for k in range(self.grid.nodes):
            self.volume[k] = ti.Vector([0.0, 0.0, 0.0])
        ti.loop_config(serialize=ti.static(runtime.is_cpu()))
        for p in range(self.particles.active[None]):
            i, sx, _gx, j, sy, _gy = self._patch(p)
            x, y = self._cells(p)
            largest = ti.abs(self.particles.stress[p]).max()
            self.weight[p] = ti.select(largest < FINITE, self.particles.volume[p], 0.0)
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    moment = ti.Vector([1.0, x - (i + a - MARGIN), y - (j + b - MARGIN)])
                    self._add(self.volume, self.grid.node(i + a, j + b), self.weight[p] * sx[a] * sy[b] * moment)
        if ti.static(self.mirrored):
            for j in range(self.grid.rows):
                self._fold(self.volume, j, ti.Vector([1.0, -1.0, 1.0]))
        for p in range(self.particles.active[None]):
            self.residual[p] = ti.select(self.weight[p] > 0.0, self.particles.stress[p], 0.0 * self.residual[p])
            self._set_weights_back(p)

    @ti.func
    def _set_weights_back(self, p):
        """Weights of the means around point p, so that a linear field is found exactly.

        The sum of s_i m_i is the field at the centroid of the centroids; its slope (d/dx, d/dy) follows from the sums
        of m_i grad s_i, which are `spread` times that slope.
        """
        i, sx, gx, j, sy, gy = self._patch(p)
        x, y = self._cells(p)
        offset, spread = ti.Vector([0.0, 0.0]), ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
        for b in ti.static(range(3)):
            for a in ti.static(range(3)):
                volume = self.volume[self.grid.node(i + a, j + b)]
                if volume[0] > 0.0:
                    centroid = ti.Vector(
                        [volume[1] / volume[0] + (i + a - MARGIN) - x, volume[2] / volume[0] + (j + b - MARGIN) - y]
                    )
                    offset += sx[a] * sy[b] * centroid
                    spread += ti.Vector([gx[a] * sy[b], sx[a] * gy[b]]).outer_product(centroid)
        to_point = ti.Vector([0.0, 0.0])
        if spread.determinant() > LEAST_SPREAD * LEAST_SPREAD:
            to_point = spread.inverse().transpose() @ offset
        else:  # a strand
            for c in ti.static(range(2)):
                if spread[c, c] > LEAST_SPREAD:
                    to_point[c] = offset[c] / spread[c, c]
        for b in ti.static(range(3)):
            for a in ti.static(range(3)):
                slope = to_point[0] * gx[a] * sy[b] + to_point[1] * sx[a] * gy[b]
                self.back[p][3 * b + a] = sx[a] * sy[b] - slope

    @ti.kernel
    def _collect(self):
        """Means of the residual at the nodes.

        In the order of the points, so that the sums are the same for any number of threads.
        """
        for k in range(self.grid.nodes):
            self.sums[k] = ti.Vector([0.0, 0.0, 0.0, 0.0])
        ti.loop_config(serialize=ti.static(runtime.is_cpu()))
        for p in range(self.particles.active[None]):
            i, sx, _gx, j, sy, _gy = self._patch(p)
            given = self.weight[p] * self.residual[p]
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    self._add(self.sums, self.grid.node(i + a, j + b), sx[a] * sy[b] * given)
        if ti.static(self.mirrored):
            for j in range(self.grid.rows):
                self._fold(self.sums, j, ti.Vector([1.0, 1.0, 1.0, -1.0]))
        for k in range(self.grid.nodes):
            if self.volume[k][0] > 0.0:
                self.sums[k] /= self.volume[k][0]

    @ti.func
    def _fold(self, sums: ti.template(), j, mirror):
        """What the points' mirror images beyond the axis give as well, in row j."""
        axis = self.grid.node(self.grid.columns - 1 - MARGIN, j)
        for n in ti.static(range(MARGIN + 1)):
            total = sums[axis - n] + mirror * sums[axis + n]
            sums[axis - n], sums[axis + n] = total, mirror * total

    @ti.kernel
    def _subtract_patch_means(self):
        """The residual less what the patch around each point says of it."""
        for p in range(self.particles.active[None]):
            i, _sx, _gx, j, _sy, _gy = self._patch(p)
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    self.residual[p] -= self.back[p][3 * b + a] * self.sums[self.grid.node(i + a, j + b)]

    @ti.kernel
    def _fade(self):
        for p in range(self.particles.active[None]):
            share = 1.0 - ti.exp((self.path[p] - self.particles.path[p]) / STRAIN)
            self.path[p] = self.particles.path[p]
            if self.weight[p] > 0.0:
                s = self.particles.stress[p] - share * self.residual[p]
                e = self.particles.volume[p] * self.law.grain_density / self.particles.mass[p] - 1.0
                s0, s1, s2, s3 = self.law.admissible((s[0], s[1], s[2], s[3]), e)
                self.particles.stress[p] = ti.Vector([s0, s1, s2, s3])
