"""Nodes as the vector unit holds them: rows of them, one after the other, or eight at once where no wall is.

Formulas are those of `grid_update`; what points gave to a node lies in eight slots, and so does what they gather there.
"""

from typing import Any

from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.vectors import LANES, eight, transposed

MIRROR = (1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0)  # of the eight slots that a point gives: x turns round
MIRROR_VELOCITY = (-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0)  # of the eight numbers that a node has


@ti.data_oriented
class Nodes:
    """The part of a store (`store.Groups`) that knows nodes; arrays and `layout` are the store's."""

    layout: Any
    grid: Grid
    points: Any
    sums: Any
    nodal: Any

    @ti.func
    def begin(self, low, high):
        """Look at which nodes of the rows there are no walls, and align the stack."""
        self.align()
        for j in range(low, high):
            self.layout.free[j, 0], self.layout.free[j, 1] = 0, 0
            if ti.static(self.layout.some_free):
                first = 0
                for i in range(self.grid.columns):  # whose last node stays alone
                    held = i == self.grid.columns - 1
                    for wall in ti.static(self.layout.walls):
                        held = held or wall.holds(i, j)
                    if held:
                        if (i - first) // LANES > self.layout.free[j, 1]:
                            self.layout.free[j, 0], self.layout.free[j, 1] = first, (i - first) // LANES
                        first = i + 1

    @ti.func
    def align(self):
        """Have vectors that registers cannot hold lie within lines of the cache.

        LLVM aligns the stack of a kernel only if it knows before it hands out registers that a vector will be there,
        such as one that is indexed by a number known only at run time.
        """
        some = self.points[0] + self.points[1]
        self.layout.some[0] = some[self.layout.first[1] % LANES]

    @ti.func
    def row(self, run: ti.template(), eights: ti.template(), j, step, option: ti.template()):
        """The phase over nodes, for those of row j: one after the other at walls, eight at once between them."""
        first, count = self.layout.free[j, 0], self.layout.free[j, 1]
        for i in range(first):
            run(self, i, j, step, option)
        if self.layout.touched[j] != 0:
            eights(self, first, count, j, step)
        else:
            for i in range(first, first + count * LANES):
                self.grid.forget(j * self.grid.columns + i)
        for i in range(first + count * LANES, self.grid.columns):
            run(self, i, j, step, option)

    @ti.func
    def read_eight_sums(self, k):
        """Mass, momentum and force of eight nodes from node k on, which are emptied."""
        a = transposed(
            self.sums[k], self.sums[k + 1], self.sums[k + 2], self.sums[k + 3], self.sums[k + 4], self.sums[k + 5],
            self.sums[k + 6], self.sums[k + 7],
        )  # fmt: skip
        for n in ti.static(range(LANES)):
            self.sums[k + n] = eight(0.0)
        return a[0], a[1], a[2], a[3] + a[4] + a[6], a[5] + a[7]

    @ti.func
    def write_eight_velocities(self, k, x, y, old):
        """Velocities of eight nodes from node k on, and their changes from old ones."""
        a = transposed(x, y, x - old[0], y - old[1], x, y, x, y)
        for n in ti.static(range(LANES)):
            self.nodal[k + n] = a[n]

    @ti.func
    def memories_of(self, k):
        """What eight nodes from node k on remember."""
        return self._eight_of(0, k), self._eight_of(1, k), self._eight_of(2, k)

    @ti.func
    def _eight_of(self, c: ti.template(), k):
        """A number of the memories of eight nodes from node k on."""
        m = ti.static(self.grid.memory)
        return eight(m[c, k], m[c, k + 1], m[c, k + 2], m[c, k + 3], m[c, k + 4], m[c, k + 5], m[c, k + 6], m[c, k + 7])

    @ti.func
    def remember_eight(self, k, memory):
        """Set what eight nodes from node k on remember."""
        for c in ti.static(range(3)):
            for n in ti.static(range(LANES)):
                self.grid.memory[c, k + n] = memory[c][n]

    @ti.func
    def read_sums(self, i, j, last: ti.template()):
        """Mass, momentum and force of node (i, j), which are emptied; i must go from left to right."""
        total = eight(0.0)
        if self.layout.touched[j] != 0:
            k = j * self.grid.columns + i
            total = self.sums[k]
            self.sums[k] = eight(0.0)
            if i == self.grid.columns - 1:
                self.layout.touched[j] = 0
        return total[0], total[1], total[2], total[3] + total[4] + total[6], total[5] + total[7]

    @ti.func
    def write_velocity(self, k, x, y, old):
        """Velocity (x, y) of node k, and its change from an old one."""
        self.nodal[k] = eight(x, y, x - old[0], y - old[1], x, y, x, y)

    @ti.func
    def clear_axis(self, k, j):
        """Nothing crosses the axis at node k: no momentum and no force along x."""
        if self.layout.touched[j] != 0:
            self.sums[k] = self.sums[k] * (0.5 + 0.5 * eight(*ti.static(MIRROR)))

    @ti.func
    def fold(self, k, image, j):
        """Add the mirrored sums of node `image` to those of node k, and empty them."""
        if self.layout.touched[j] != 0:
            self.sums[k] = self.sums[k] + self.sums[image] * eight(*ti.static(MIRROR))
            self.sums[image] = eight(0.0)

    @ti.func
    def unfold(self, k, image):
        """Mirror the velocities of node k to node `image`."""
        self.nodal[image] = self.nodal[k] * eight(*ti.static(MIRROR_VELOCITY))
