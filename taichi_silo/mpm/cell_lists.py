"""Which points touch a node: lists of points by the first node of their patch, for sums without atomics.

On a GPU each node takes what its points give it, in a fixed order, instead of points adding to nodes in whatever order
they come. A point whose patch begins at node (i, j) touches the nodes up to (i + NODES - 1, j + NODES - 1), so node
(i, j) asks the NODES x NODES lists before it. Points enter lists in any order; they are asked in that of their numbers,
and two runs are equal bit by bit.
"""

import numpy as np

from taichi_silo.mpm.contracts import Shape
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.point_weights import weights
from taichi_silo.mpm.runtime import whole_numbers

MOST_ROOM = 32  # of a list
NOBODY = 2**31 - 1


@ti.data_oriented
class CellLists:
    """Lists for this step and the next, which take turns.

    A list has room for twice as many points as a cell has at the start, and some; further points join the crowd, which
    every node asks.

    ==============  ======================  ====================================================================
    field           shape                   meaning
    ==============  ======================  ====================================================================
    length          turn, patch * node      how many points have entered a list
    member          patch * node * room     their numbers
    crowd           point * patch           numbers of those that found no room, by patches
    crowded         turn, patch             how many there are
    first_of_crowd  patch, point            node at which the patch of such a point begins
    ==============  ======================  ====================================================================

    Raises
    ------
    ValueError
        if the grid is periodic and narrower than a patch, which then has a node twice.

    """

    def __init__(self, particles: Particles, grid: Grid, shape: Shape):
        if grid.periodic and grid.columns < shape.NODES:
            raise ValueError(f"a periodic grid of {grid.columns} columns is too narrow for parallel tasks")
        self.particles, self.grid, self.shape = particles, grid, shape
        self.room = self._room()
        patches, points = shape.PATCHES, particles.count
        lists, places = (2, patches * grid.nodes), (patches * grid.nodes * self.room,)
        crowds = (points * patches,), (2, patches), (patches, points)
        self.length, self.member, self.crowd, self.crowded, self.first_of_crowd = whole_numbers(lists, places, *crowds)

    def _room(self) -> int:
        place = self.particles.array("position") / (self.grid.cell_size, self.grid.first_cell_height)
        place = place[np.isfinite(place).all(axis=1)]
        most = np.unique(np.floor(place), axis=0, return_counts=True)[1].max(initial=1)
        return min(2 * int(most) + 4, MOST_ROOM)

    @ti.kernel
    def fill(self, turn: ti.i32):
        """Enter all points anew."""
        for n in range(2 * self.shape.PATCHES * self.grid.nodes):
            self.length[n % 2, n // 2] = 0
            if n < 2 * self.shape.PATCHES:
                self.crowded[n % 2, n // 2] = 0
        for p in range(self.particles.places()):
            if self.particles.is_there(p):
                self.enter(p, turn)

    @ti.func
    def empty(self, k, turn):
        """Empty what node k has of the lists of a turn."""
        for patch in ti.static(range(self.shape.PATCHES)):
            self.length[turn, patch * self.grid.nodes + k] = 0
            if k == 0:
                self.crowded[turn, patch] = 0

    @ti.func
    def enter(self, p, turn):
        """Enter point p into the lists of its patches."""
        for patch in ti.static(range(self.shape.PATCHES)):
            i, _sx, _gx, j, _sy, _gy = weights(self.particles, self.grid, self.shape, p, 0, patch)
            first = self.grid.node(ti.cast(i, ti.i32), ti.cast(j, ti.i32))
            own = patch * self.grid.nodes + ti.max(0, ti.min(first, self.grid.nodes - 1))  # if its place is no number
            place = ti.atomic_add(self.length[turn, own], 1)
            if place < self.room:
                self.member[own * self.room + place] = p
            else:
                further = ti.atomic_add(self.crowded[turn, patch], 1)
                self.crowd[patch * self.particles.count + further] = p
                self.first_of_crowd[patch, p] = own - patch * self.grid.nodes

    @ti.func
    def before(self, i, j, a, b):
        """Number of the node a columns and b rows before node (i, j); -1 if there is none."""
        column, row = i - a, j - b
        if ti.static(self.grid.periodic):
            column = column % self.grid.columns
        number = row * self.grid.columns + column
        if row < 0 or column < 0:
            number = -1
        return number

    @ti.func
    def ask(self, visitor: ti.template(), patch: ti.template(), i, j, turn):
        """Let a visitor `visit(p)` the points whose patch has node (i, j)."""
        for n in range(self.shape.NODES * self.shape.NODES):
            first = self.before(i, j, n % self.shape.NODES, n // self.shape.NODES)
            if first >= 0:
                own = patch * self.grid.nodes + first
                count, p = ti.min(self.length[turn, own], self.room), -1
                for _ in range(count):
                    p = self.following(self.member, own * self.room, count, p)
                    visitor.visit(p)
                crowd, q = self.crowded[turn, patch], -1
                for _ in range(crowd):
                    q = self.following(self.crowd, patch * self.particles.count, crowd, q)
                    if self.first_of_crowd[patch, q] == first:
                        visitor.visit(q)

    @ti.func
    def following(self, numbers: ti.template(), begin, count, last):
        """The least number above `last` among so many of a list from `begin` on."""
        found = NOBODY
        for n in range(begin, begin + count):
            if numbers[n] > last and numbers[n] < found:
                found = numbers[n]
        return found
