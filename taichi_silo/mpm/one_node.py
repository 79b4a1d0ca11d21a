"""A node that takes what its points give it: the store of a phase over points, seen from one node."""

from typing import Any

from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real


def same(one: object, other: object) -> bool:
    """Whether two fields are one (asked while a kernel is compiled)."""
    return one is other


@ti.func
def chosen(values: ti.template(), number):
    """The value of that number among some that stand in a tuple; 0 if there is none."""
    found = 0.0 * values[0]
    for n in ti.static(range(len(values))):
        found = ti.select(number == n, values[n], found)
    return found


@ti.data_oriented
class OneNode:
    """Takes of what a point gives through one of its patches what is for one node.

    Where a patch begins is found anew: in another task it may round to the next cell. The node at whose list a point is
    then asked in vain has no weight.

    Parameters
    ----------
    fields : the store of points and nodes.
    patch : number of the patch.
    sums : mass, momentum and force, variables of the kernel to which is added.
    place : column and row of the node.
    run, step, option : function of the phase, and its last arguments.

    """

    def __init__(self, fields: Fields, patch: int, sums: tuple, place: tuple, run: Any, step: Any, option: Any):
        self.fields, self.particles, self.grid, self.read = fields, fields.particles, fields.grid, fields.read
        self.patch, (self.mass, self.momentum, self.force), (self.column, self.row) = patch, sums, place
        self.run, self.step, self.option = run, step, option

    @ti.func
    def visit(self, p):
        """Let point p give."""
        self.run(self, p, 0, self.step, self.option)

    def patches(self) -> tuple[int, ...]:
        """The one."""
        return (self.patch,)

    @ti.func
    def touched(self, p, t, patch: ti.template()):
        """Column of the node, its weight and derivative along x, its row, the same along y."""
        i, sx, gx, j, sy, gy = self.fields.touched(p, t, patch)
        a, b = self.column - ti.cast(i, ti.i32), self.row - ti.cast(j, ti.i32)
        if ti.static(self.grid.periodic):
            a = a % self.grid.columns
        return i + a, (chosen(sx, a),), (chosen(gx, a),), j + b, (chosen(sy, b),), (chosen(gy, b),)

    @ti.func
    def add(self, sums: ti.template(), k, value):
        """Add to one of the three sums."""
        if ti.static(same(sums, self.grid.mass)):
            self.mass += value
        elif ti.static(same(sums, self.grid.momentum)):
            self.momentum += value
        else:
            self.force += value


@ti.func
def take(fields: ti.template(), lists: ti.template(), k, turn, run: ti.template(), step, option: ti.template()):
    """Add to the sums of node k what the function `run` of a phase lets the points of its lists give."""
    mass, momentum, force = ti.cast(0.0, real), ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    i, j = k % fields.grid.columns, k // fields.grid.columns
    for patch in ti.static(fields.patches()):
        for node in ti.static([OneNode(fields, patch, (mass, momentum, force), (i, j), run, step, option)]):
            lists.ask(node, patch, i, j, turn)
    fields.grid.mass[k] = fields.grid.mass[k] + mass
    fields.grid.momentum[k] = fields.grid.momentum[k] + momentum
    fields.grid.force[k] = fields.grid.force[k] + force
