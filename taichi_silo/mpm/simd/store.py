"""Points and nodes as the vector unit holds them, and how eight points at once reach their nodes.

Formulas are those of `p2g`, `g2p` and the law; only who scatters and who gathers is written here. What makes it fast:
vectors of eight that stay vectors of the processor, and points in the order of their cells, so that the sums of a run
of points with the same nodes stay in registers.
"""

from typing import Any

from taichi_silo.mpm.contracts import Shape
from taichi_silo.mpm.geometry import Surroundings
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.p2g import point_contributions
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.point_weights import weights
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.lane_maths import greatest, larger, smaller
from taichi_silo.mpm.simd.nodes import Nodes
from taichi_silo.mpm.simd.vectors import LANES, eight, transposed

STRIPS = 16  # of points, at most
HALVES = 2  # of the strips, which take turns


@ti.func
def along_x(s, g):
    """Weights along x of the eight slots of `p2g`."""
    return eight(s, s, s, s, g, g, s, s)


@ti.func
def along_y(s, g):
    """Weights along y of the eight slots."""
    return eight(s, s, s, s, s, s, g, g)


@ti.data_oriented
class OfStep:
    """What groups of points give to their nodes in a step: the formula is that of `p2g`."""

    def __init__(self, grid: Grid, shape: Shape, surroundings: Surroundings):
        self.grid, self.shape, self.surroundings = grid, shape, surroundings

    @ti.func
    def given(self, store: ti.template(), g, t, number):
        """Eight slots of group g of a store."""
        return point_contributions(store, self.grid, self.surroundings, g, t)

    @ti.func
    def weights(self, store: ti.template(), g, t, patch: ti.template()):
        """As `point_weights.weights`."""
        return weights(store, self.grid, self.shape, g, t, patch)

    @ti.func
    def along_x(self, s, g):
        """Weights of the slots along x, from weight and slope of a node."""
        return along_x(s, g)

    @ti.func
    def along_y(self, s, g):
        """The same along y."""
        return along_y(s, g)


class Layout:
    """Where everything of a group of eight points stands.

    ==============  ===============  ===================================================================
    array of eight  shape            meaning
    ==============  ===============  ===================================================================
    points          group * record   the fields of eight points, one after the other; what they keep within a step
    sums            node             what points gave to a node, by slots
    nodal           node             what a point may gather there: velocity, change, velocity, velocity
    ==============  ===============  ===================================================================

    `order` (field, group * 8) is the number of each point, `particles.count` where there is none. The groups are cut
    into strips of some rows of cells: `first` (STRIPS + 1) has the first group of each, `half` says in which of two
    turns its points add to the nodes; neighbours have different ones, and strips of the same half no rows of nodes in
    common, so that each strip may be another thread's. `free` (row, 2) says from which column on how many times eight
    nodes are at no wall (`walls`; None: nowhere), `touched` (row) says whether sums of a row are not zero, `reach`
    (STRIPS, 16: a line of the cache each) the first and last row of nodes that a strip touched. `some` is for `align`.
    """

    def __init__(
        self, particles: Particles, grid: Grid, shape: Shape, surroundings: Surroundings, kept: int, walls: tuple | None
    ):  # fmt: skip
        self.particles, self.grid, self.shape, self.surroundings = particles, grid, shape, surroundings
        self.walls, self.some_free = walls or (), walls is not None
        self.groups = (particles.count + LANES - 1) // LANES
        widths = [particles.WIDTHS.get(name, 1) for name in particles.names]
        self.record = sum(widths) + kept  # which are its last numbers
        self.begins = {name: sum(widths[:k]) for k, name in enumerate(particles.names)}
        self.order = ti.field(ti.i32, shape=self.groups * LANES)
        self.first, self.half = ti.field(ti.i32, shape=STRIPS + 1), ti.field(ti.i32, shape=STRIPS)
        self.free = ti.field(ti.i32, shape=(grid.rows, 2))
        self.some = ti.field(real, shape=1)
        self.touched = ti.field(ti.i32, shape=grid.rows)
        self.reach = ti.field(ti.i32, shape=(STRIPS, 16))


@ti.data_oriented
class Groups(Nodes):
    """The store of the vector unit, over arrays that were handed to a kernel (see `field_store` for the members)."""

    def __init__(self, layout: Layout, points: Any, sums: Any, nodal: Any):
        self.layout, self.points, self.sums, self.nodal = layout, points, sums, nodal
        self.particles, self.grid, self.shape = layout.particles, layout.grid, layout.shape
        self.order, self.of_step = layout.order, OfStep(layout.grid, layout.shape, layout.surroundings)

    # --- fields of the points of group g -------------------------------------------------------------------------

    @ti.func
    def read(self, name: ti.template(), g):
        """A field: eight numbers, or a tuple of its components."""
        width = ti.static(self.particles.WIDTHS.get(name, 1))
        k = g * self.layout.record + ti.static(self.layout.begins[name])
        if ti.static(width == 1):
            return self.points[k]
        if ti.static(width == 2):
            return self.points[k], self.points[k + 1]
        return self.points[k], self.points[k + 1], self.points[k + 2], self.points[k + 3]

    @ti.func
    def write(self, name: ti.template(), g, value):
        """Set a field to eight numbers, or a tuple of them."""
        width = ti.static(self.particles.WIDTHS.get(name, 1))
        k = g * self.layout.record + ti.static(self.layout.begins[name])
        if ti.static(width == 1):
            self.points[k] = value
        else:
            for c in ti.static(range(width)):
                self.points[k + c] = value[c]

    @ti.func
    def keep(self, fields: ti.template(), g, values):
        """Set the numbers that outlive a phase."""
        for c in ti.static(range(len(fields))):
            self.points[(g + 1) * self.layout.record - ti.static(len(fields) - c)] = values[c]

    @ti.func
    def kept(self, fields: ti.template(), g):
        """The numbers that outlive a phase."""
        k = (g + 1) * self.layout.record - ti.static(len(fields))
        return (
            self.points[k], self.points[k + 1], self.points[k + 2], self.points[k + 3], self.points[k + 4],
            self.points[k + 5],
        )  # fmt: skip

    @ti.func
    def hand(self, function: ti.template(), g, t, value):
        """Call the function for each point."""
        strip = 0
        while g >= self.layout.first[strip + 1]:
            strip += 1
        for lane in ti.static(range(LANES)):
            function(self, self.order[g * LANES + lane], value[lane], self.layout.half[strip])

    @ti.func
    def add(self, sums: ti.template(), k, value):
        """Add to entry k of a sum."""
        sums[k] = sums[k] + value

    @ti.func
    def each(self, function: ti.template(), g):
        """A function of the number of each point."""
        values = eight(0.0)
        for lane in ti.static(range(LANES)):
            values[lane] = function(self.number(g, lane))
        return values

    @ti.func
    def number(self, g, lane):
        """That of a point; of what fills up the last group that of the last point, which it is like."""
        return self.order[ti.max(ti.min(g * LANES + lane, self.particles.active[None] - 1), 0)]

    @ti.func
    def there(self, g):
        """Which of a group are points, not what fills it up."""
        number = eight(*ti.static([float(lane) for lane in range(LANES)]))
        return number < eight(ti.cast(self.particles.active[None] - g * LANES, real))

    # --- between points and nodes ---------------------------------------------------------------------------------

    @ti.func
    def strips_of(self, t, threads: ti.template()):
        """First of the strips of thread t, and of those of the next."""
        return t * STRIPS // threads, (t + 1) * STRIPS // threads

    @ti.func
    def points_of(self, t, threads: ti.template()):
        """First of the groups of thread t, and of those of the next."""
        first, last = self.strips_of(t, threads)
        return self.layout.first[first], self.layout.first[last]

    @ti.func
    def scatter(self, run: ti.template(), t, threads: ti.template(), step, option: ti.template(), turn):
        """Particles to grid: what thread t's strips of one half give (the formula is `p2g`'s, not `run`)."""
        first, last = self.strips_of(t, threads)
        for strip in range(first, last):
            if self.layout.half[strip] == turn:
                self.scatter_strip(strip, t, self.of_step, 0)

    @ti.func
    def scatter_strip(self, strip, t, of: ti.template(), number):
        """Into the sums, what the points of a strip give, `of` a step or something else (as `OfStep`)."""
        lowest, highest = eight(self.grid.rows), eight(0.0)
        nothing = eight(0.0)
        c00, c01, c02 = nothing, nothing, nothing
        c10, c11, c12 = nothing, nothing, nothing
        c20, c21, c22 = nothing, nothing, nothing
        at, columns = -2, self.grid.columns  # nothing has been collected yet, and node 0 does not follow it
        for g in range(self.layout.first[strip], self.layout.first[strip + 1]):
            of_point = transposed(*of.given(self, g, t, number))
            for patch in ti.static(range(of.shape.PATCHES)):
                i, sx, gx, j, sy, gy = of.weights(self, g, t, patch)
                lowest, highest = smaller(j, lowest), larger(j, highest)
                first = j * columns + i
                for lane in ti.static(range(LANES)):
                    k, v = self.within(first[lane], of.shape.NODES), of_point[lane]
                    if ti.static(of.shape.NODES == 3):
                        # as long as the points have the same nodes, their sums stay here
                        if k == at + 1:
                            self.sums[at] = self.sums[at] + c00
                            self.sums[at + columns] = self.sums[at + columns] + c10
                            self.sums[at + 2 * columns] = self.sums[at + 2 * columns] + c20
                            c00, c10, c20 = c01, c11, c21
                            c01, c11, c21 = c02, c12, c22
                            c02, c12, c22 = nothing, nothing, nothing
                            at = k
                        if k != at:
                            self.flush(at, c00, c01, c02, c10, c11, c12, c20, c21, c22)
                            c00, c01, c02 = nothing, nothing, nothing
                            c10, c11, c12 = nothing, nothing, nothing
                            c20, c21, c22 = nothing, nothing, nothing
                            at = k
                        x0, x1, x2 = (
                            of.along_x(sx[0][lane], gx[0][lane]), of.along_x(sx[1][lane], gx[1][lane]),
                            of.along_x(sx[2][lane], gx[2][lane]),
                        )  # fmt: skip
                        y = v * of.along_y(sy[0][lane], gy[0][lane])
                        c00, c01, c02 = c00 + x0 * y, c01 + x1 * y, c02 + x2 * y
                        y = v * of.along_y(sy[1][lane], gy[1][lane])
                        c10, c11, c12 = c10 + x0 * y, c11 + x1 * y, c12 + x2 * y
                        y = v * of.along_y(sy[2][lane], gy[2][lane])
                        c20, c21, c22 = c20 + x0 * y, c21 + x1 * y, c22 + x2 * y
                    else:
                        for b in ti.static(range(of.shape.NODES)):
                            y = v * of.along_y(sy[b][lane], gy[b][lane])
                            for a in ti.static(range(of.shape.NODES)):
                                node = k + b * columns + a
                                self.sums[node] = self.sums[node] + of.along_x(sx[a][lane], gx[a][lane]) * y
        self.flush(at, c00, c01, c02, c10, c11, c12, c20, c21, c22)
        low = ti.max(0, ti.cast(0.0 - greatest(0.0 - lowest), ti.i32))
        high = ti.min(self.grid.rows, ti.cast(greatest(highest), ti.i32) + of.shape.NODES)
        self.layout.reach[strip, 0], self.layout.reach[strip, 1] = low, high
        for j in range(low, high):
            self.layout.touched[j] = 1

    @ti.func
    def within(self, first, nodes: ti.template()):
        """Number of the first node of a patch of so many an axis, one of the grid's: so addresses cannot overflow."""
        span = ti.static((nodes - 1) * (self.grid.columns + 1))
        return ti.max(0, ti.min(ti.cast(first, ti.i32), self.grid.nodes - 1 - span))

    @ti.func
    def flush(self, k, c00, c01, c02, c10, c11, c12, c20, c21, c22):
        """Add nine nodes' sums from node k on."""
        if k >= 0:
            rows = ((c00, c01, c02), (c10, c11, c12), (c20, c21, c22))
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    node = k + b * self.grid.columns + a
                    self.sums[node] = self.sums[node] + rows[b][a]

    @ti.func
    def gather(self, field: ti.template(), g, t):
        """Grid to particles: the eight slots that the points of group g gather, and the first once more (S v_x)."""
        t0, t1, t2, t3, t4, t5, t6, t7 = self.from_patch(g, t, 0)
        for patch in ti.static(range(1, self.shape.PATCHES)):
            a0, a1, a2, a3, a4, a5, a6, a7 = self.from_patch(g, t, patch)
            t0, t1, t2, t3 = t0 + a0, t1 + a1, t2 + a2, t3 + a3
            t4, t5, t6, t7 = t4 + a4, t5 + a5, t6 + a6, t7 + a7
        return t0, t1, t2, t3, t4, t5, t6, t7, t0

    @ti.func
    def from_patch(self, g, t, patch: ti.template()):
        """The eight slots that the points of group g gather from one patch of nodes."""
        i, sx, gx, j, sy, gy = weights(self, self.grid, self.shape, g, t, patch)
        first = j * self.grid.columns + i
        return transposed(
            self.from_nodes(0, first, sx, gx, sy, gy), self.from_nodes(1, first, sx, gx, sy, gy),
            self.from_nodes(2, first, sx, gx, sy, gy), self.from_nodes(3, first, sx, gx, sy, gy),
            self.from_nodes(4, first, sx, gx, sy, gy), self.from_nodes(5, first, sx, gx, sy, gy),
            self.from_nodes(6, first, sx, gx, sy, gy), self.from_nodes(7, first, sx, gx, sy, gy),
        )  # fmt: skip

    @ti.func
    def from_nodes(self, lane: ti.template(), first, sx, gx, sy, gy):
        """The eight slots of one point."""
        k, total = self.within(first[lane], self.shape.NODES), eight(0.0)
        if ti.static(self.shape.NODES == 3):
            x0, x1, x2 = (
                along_x(sx[0][lane], gx[0][lane]), along_x(sx[1][lane], gx[1][lane]), along_x(sx[2][lane], gx[2][lane])
            )  # fmt: skip
            for b in ti.static(range(3)):
                n = k + b * self.grid.columns
                row = self.nodal[n] * x0 + self.nodal[n + 1] * x1 + self.nodal[n + 2] * x2
                total = total + row * along_y(sy[b][lane], gy[b][lane])
        else:
            for b in ti.static(range(self.shape.NODES)):
                for a in ti.static(range(self.shape.NODES)):
                    weight = along_x(sx[a][lane], gx[a][lane]) * along_y(sy[b][lane], gy[b][lane])
                    total = total + self.nodal[k + b * self.grid.columns + a] * weight
        return total
