"""A node that takes what its points give it: the store of a phase over points, seen from one node."""

from typing import Any

from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.language import ti


def same(one: object, other: object) -> bool:
    """Whether two fields are one (asked while a kernel is compiled)."""
    return one is other


@ti.func
def chosen(values: ti.template(), number):
    """The value of that number among some that stand in a tuple."""
    found = values[0]
    for n in ti.static(range(1, len(values))):
        found = ti.select(number == n, values[n], found)
    return found


@ti.data_oriented
class OneNode:
    """Takes of what a point gives through one of its patches what is for one node.

    Parameters
    ----------
    fields : the store of points and nodes.
    patch : number of the patch.
    sums : mass, momentum and force, variables of the kernel to which is added.
    place : columns and rows from the first node of the patch to this one; variables of the kernel.
    run, step, option : function of the phase, and its last arguments.

    """

    def __init__(self, fields: Fields, patch: int, sums: tuple, place: tuple, run: Any, step: Any, option: Any):
        self.fields, self.particles, self.grid, self.read = fields, fields.particles, fields.grid, fields.read
        self.patch, (self.mass, self.momentum, self.force), (self.a, self.b) = patch, sums, place
        self.run, self.step, self.option = run, step, option

    @ti.func
    def visit(self, p, a, b):
        """Let point p give, a columns and b rows from the first node of its patch."""
        self.a, self.b = a, b
        self.run(self, p, 0, self.step, self.option)

    def patches(self) -> tuple[int, ...]:
        """The one."""
        return (self.patch,)

    @ti.func
    def touched(self, p, t, patch: ti.template()):
        """Column of the node, its weight and derivative along x, its row, the same along y."""
        i, sx, gx, j, sy, gy = self.fields.touched(p, t, patch)
        return (
            i + self.a, (chosen(sx, self.a),), (chosen(gx, self.a),),
            j + self.b, (chosen(sy, self.b),), (chosen(gy, self.b),),
        )  # fmt: skip

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
    mass, momentum, force, a, b = 0.0 * step.dt, ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0]), 0, 0
    for patch in ti.static(fields.patches()):
        for node in ti.static([OneNode(fields, patch, (mass, momentum, force), (a, b), run, step, option)]):
            lists.ask(node, patch, k % fields.grid.columns, k // fields.grid.columns, turn)
    fields.grid.mass[k] = fields.grid.mass[k] + mass
    fields.grid.momentum[k] = fields.grid.momentum[k] + momentum
    fields.grid.force[k] = fields.grid.force[k] + force
