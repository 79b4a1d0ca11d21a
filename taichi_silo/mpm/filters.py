"""Filters of the points' stresses.

Points outnumber nodes, so some patterns of stress, a checkerboard above all, give no force to any node and nothing
resists them: the null space of the map from points to nodes.

The contract: `ACTIVE`, and `phases()`, the phases that a filter adds after the stresses are known (see `executors`).
One that works `BETWEEN_LAUNCHES` has none of them, but `waits`, whether it acts in flow alone, `begin()` for the start
of `Solver.advance`, `steps_within(speed, dt)`, how many steps may pass before it acts, `passed(steps, speed, dt)`,
`keep(stayed)` when points have been taken out, and for checkpoints `state()` and `restore(state)`, or of None.

A filtered stress is pulled back to what the law admits.
"""

from typing import Any

from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.executors import COLLECT, NODES, POINTS, Phase
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.several import admissible
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.patch_filter import PatchFilter
from taichi_silo.mpm.runtime import real

FLAT = 1e-6  # spread of points in a cell, over the cell squared, below which they show no slope


class Unfiltered:
    """Stresses stay as they are."""

    ACTIVE = BETWEEN_LAUNCHES = False

    def work_on(self, executor: Any) -> None:
        """Nothing (see `PatchFilter`)."""


@ti.data_oriented
class CellFilter:
    """What both filters share: sums over a patch of nodes or cells, and the way back."""

    ACTIVE, BETWEEN_LAUNCHES = True, False

    def __init__(self, particles: Particles, grid: Grid, law: Law, mirrored: bool = False):
        self.particles, self.grid, self.law = particles, grid, law
        self.sums = ti.Vector.field(self.WIDTH, real, shape=grid.copies * grid.nodes)
        self.result = ti.Vector.field(self.WIDTH, real, shape=grid.nodes)

    def phases(self) -> list[Phase]:
        """Points to cells, cells, cells to points."""
        return [Phase(COLLECT, self.collect), Phase(NODES, self.settle), Phase(POINTS, self.apply)]

    @ti.func
    def cell(self, p, t):
        """Column and row of the cell of point p, and the point's place in it, 0 to 1 along both axes."""
        x = self.particles.position[p][0] / self.grid.cell_size
        y = self.particles.position[p][1] / self.grid.cell_height(t)
        i, j = ti.floor(x), ti.floor(y)
        column, row = ti.cast(i, ti.i32) + MARGIN, ti.cast(j, ti.i32) + MARGIN
        if ti.static(not self.grid.periodic):
            column = ti.max(0, ti.min(column, self.grid.columns - 2))
        return column, ti.max(0, ti.min(row, self.grid.rows - 2)), x - i, y - j

    @ti.func
    def total(self, i, j):
        """Sums of all threads at (i, j), which are emptied."""
        k = j * self.grid.columns + i
        found = self.sums[k]
        for copy in ti.static(range(1, self.grid.copies)):
            found += self.sums[copy * self.grid.nodes + k]
        for copy in ti.static(range(self.grid.copies)):
            self.sums[copy * self.grid.nodes + k] = 0.0 * found
        return k, found

    @ti.func
    def put(self, p, s0, s1, s2, s3):
        """The admissible stress next to a filtered one."""
        e = self.particles.volume[p] * self.law.grain_density / self.particles.mass[p] - 1.0
        s0, s1, s2, s3 = admissible(self.law, self.particles, p, (s0, s1, s2, s3), e)
        self.particles.stress[p] = ti.Vector([s0, s1, s2, s3])


@ti.data_oriented
class NullSpace(CellFilter):
    """Keeps of the stresses in a cell only what its hat functions can feel: the plane c + g_x x + g_y y.

    In a cell, the derivatives of the four hats along x are combinations of {1, y}, along y of {1, x}. Stress patterns
    that are orthogonal (weighted with the points' volumes) to {1, x, y} give no force to any node; they are removed,
    by a projection: done twice it is done once, nodal forces of hats and linear fields of stress stay exactly as they
    are, and one point a cell stays as it is. Orthonormal basis by Gram and Schmidt, without the directions that the
    points do not span. (The null space of the weights themselves, which Gritton and Berzins 2017 filter, is empty in a
    cell of four points: their matrix has rank four.)
    """

    WIDTH = 18  # V, Vx, Vy, Vxx, Vxy, Vyy, then V s, V s x, V s y of four stresses; later the plane

    @ti.func
    def collect(self, store: ti.template(), p, t, step, option: ti.template()):
        """Moments of volume and stress."""
        i, j, x, y = self.cell(p, t)
        V, s = self.particles.volume[p], self.particles.stress[p]
        row = ti.Vector([0.0] * 18)
        row[0], row[1], row[2], row[3], row[4], row[5] = V, V * x, V * y, V * x * x, V * x * y, V * y * y
        for k in ti.static(range(4)):
            row[6 + k], row[10 + k], row[14 + k] = V * s[k], V * s[k] * x, V * s[k] * y
        store.add(self.sums, t * self.grid.nodes + self.grid.node(i, j), row)

    @ti.func
    def settle(self, store: ti.template(), i, j, step, option: ti.template()):
        """The plane of a cell: mean place, slope of y on x, then mean and slopes of each stress."""
        k, m = self.total(i, j)
        if m[0] > 0.0:
            x, y = m[1] / m[0], m[2] / m[0]
            xx, xy, yy = m[3] / m[0] - x * x, m[4] / m[0] - x * y, m[5] / m[0] - y * y
            lean = ti.select(xx > FLAT, xy / ti.max(xx, FLAT), 0.0)
            rest = yy - lean * xy
            plane = 0.0 * m
            plane[0], plane[1], plane[2] = x, y, lean
            for c in ti.static(range(4)):
                mean = m[6 + c] / m[0]
                sx, sy = m[10 + c] / m[0] - mean * x, m[14 + c] / m[0] - mean * y
                plane[6 + c] = mean
                plane[10 + c] = ti.select(xx > FLAT, sx / ti.max(xx, FLAT), 0.0)
                plane[14 + c] = ti.select(rest > FLAT, (sy - lean * sx) / ti.max(rest, FLAT), 0.0)
            self.result[k] = plane

    @ti.func
    def apply(self, store: ti.template(), p, t, step, option: ti.template()):
        """The plane at the point."""
        i, j, x, y = self.cell(p, t)
        plane = self.result[self.grid.node(i, j)]
        u = x - plane[0]
        w = y - plane[1] - plane[2] * u
        s = ti.Vector([0.0, 0.0, 0.0, 0.0])
        for c in ti.static(range(4)):
            s[c] = plane[6 + c] + plane[10 + c] * u + plane[14 + c] * w
        self.put(p, s[0], s[1], s[2], s[3])


@ti.data_oriented
class Smoothing(CellFilter):
    """Points to nodes and back with linear weights: what the paper's authors' own code did.

    No projection: with one point a cell it spreads stress like a diffusion of h^2 / (4 dt), in each step again.
    """

    WIDTH = 5  # S V, S V s of four stresses

    @ti.func
    def collect(self, store: ti.template(), p, t, step, option: ti.template()):
        """Volume-weighted sums."""
        i, j, x, y = self.cell(p, t)
        V, s = self.particles.volume[p], self.particles.stress[p]
        row = ti.Vector([V, V * s[0], V * s[1], V * s[2], V * s[3]])
        for b in ti.static(range(2)):
            for a in ti.static(range(2)):
                share = (x if ti.static(a == 1) else 1.0 - x) * (y if ti.static(b == 1) else 1.0 - y)
                store.add(self.sums, t * self.grid.nodes + self.grid.node(i + a, j + b), share * row)

    @ti.func
    def settle(self, store: ti.template(), i, j, step, option: ti.template()):
        """Means."""
        k, m = self.total(i, j)
        if m[0] > 0.0:
            self.result[k] = m / m[0]

    @ti.func
    def apply(self, store: ti.template(), p, t, step, option: ti.template()):
        """Their interpolation."""
        i, j, x, y = self.cell(p, t)
        s = ti.Vector([0.0] * 5)
        for b in ti.static(range(2)):
            for a in ti.static(range(2)):
                share = (x if ti.static(a == 1) else 1.0 - x) * (y if ti.static(b == 1) else 1.0 - y)
                s += share * self.result[self.grid.node(i + a, j + b)]
        self.put(p, s[1], s[2], s[3], s[4])


FILTERS = {"patch": PatchFilter, "none": None, "null-space": NullSpace, "smoothing": Smoothing}
