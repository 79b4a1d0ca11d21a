"""A node that takes what its points give it: the store of a phase over points, seen from one node."""

from typing import Any

import taichi as ti

from taichi_silo.mpm.field_store import Fields


def same(one: object, other: object) -> bool:
    """Whether two fields are one (asked while a kernel is compiled)."""
    return one is other


@ti.data_oriented
class OneNode:
    """Takes of what a point gives through one of its patches only what is for one node.

    Parameters
    ----------
    fields : the store of points and nodes.
    patch : number of the patch.
    k : the node.
    sums : mass, momentum and force, variables of the kernel to which is added.
    run, step, option : function of the phase, and its last arguments.

    """

    def __init__(self, fields: Fields, patch: int, k: Any, sums: tuple, run: Any, step: Any, option: Any):
        self.particles, self.grid, self.read = fields.particles, fields.grid, fields.read
        self.patch, self.k, (self.mass, self.momentum, self.force) = patch, k, sums
        self.run, self.step, self.option = run, step, option

    @ti.func
    def visit(self, p):
        """Let point p give."""
        self.run(self, p, 0, self.step, self.option)

    @ti.func
    def takes(self, patch: ti.template(), k):
        """Whether this is the patch and the node."""
        taken = False
        if ti.static(patch == self.patch):
            taken = k == self.k
        return taken

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
    mass, momentum, force = 0.0 * step.dt, ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    for patch in ti.static(range(lists.shape.PATCHES)):
        for node in ti.static([OneNode(fields, patch, k, (mass, momentum, force), run, step, option)]):
            lists.ask(node, patch, k % fields.grid.columns, k // fields.grid.columns, turn)
    fields.grid.mass[k] = fields.grid.mass[k] + mass
    fields.grid.momentum[k] = fields.grid.momentum[k] + momentum
    fields.grid.force[k] = fields.grid.force[k] + force
