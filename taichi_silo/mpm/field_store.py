"""Points and nodes as the fields hold them, and the contract of a store.

A phase reads and writes points and nodes through the store of the executor that runs it: the fields themselves, or what
the vector unit holds (`simd.store`). A store offers

`read(name, p)`, `write(name, p, value)`
    a field of point p (see `Particles`): a value, or a tuple of its components.
`patches()`, `touched(p, t, patch)`
    through which patches a point gives, to which nodes and with which weights (see `point_weights.weights`).
`keep(fields, p, values)`, `kept(fields, p)`
    numbers of point p that outlive a phase, not a step; a store may have a place of its own for them.
`each(function, p)`, `hand(function, p, t, value)`
    the value of a function of the point's number; a function (store, number, value, copy) called with a value of the
    point and the copy of sums that is its own.
`add(sums, k, value)`
    to entry k of a sum that others of the same copy add to.
`gather(field, p, t)`
    what `g2p.gather` finds for point p.
`begin(low, high)`, `row(run, eights, j, step, option)`
    what a thread, whose rows are `low` to `high`, does before its steps; a phase over the nodes of row j.
`read_sums(i, j, last)`, `write_velocity(k, x, y, old)`
    mass, momentum (2) and force (2) of node (i, j), which are emptied; velocity and change of node k.
`clear_axis(k, j)`, `fold(k, image, j)`, `unfold(k, image)`
    of a row j with an axis of symmetry: see `mirrored_solver`.

For the vector unit p is the number of a group of eight points, and a value eight numbers.
"""

from taichi_silo.mpm import g2p
from taichi_silo.mpm.contracts import Shape
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.point_weights import weights


@ti.data_oriented
class Fields:
    """The store of an executor that works on the fields of particles and grid themselves."""

    def __init__(self, particles: Particles, grid: Grid, shape: Shape, atomic: bool):
        self.particles, self.grid, self.shape, self.atomic = particles, grid, shape, atomic
        self.read, self.write = particles.read, particles.write

    def patches(self) -> tuple[int, ...]:
        """Numbers of the patches through which points give."""
        return tuple(range(self.shape.PATCHES))

    @ti.func
    def touched(self, p, t, patch: ti.template()):
        """First column, weights and derivatives along x, first row, the same along y, of the nodes point p gives to."""
        return weights(self, self.grid, self.shape, p, t, patch)

    @ti.func
    def add(self, sums: ti.template(), k, value):
        """Add to entry k of a sum."""
        if ti.static(self.atomic):
            sums[k] += value
        else:
            sums[k] = sums[k] + value

    @ti.func
    def keep(self, fields: ti.template(), p, values):
        """Set the entries of point p."""
        for c in ti.static(range(len(fields))):
            fields[c][p] = values[c]

    @ti.func
    def kept(self, fields: ti.template(), p):
        """The entries of point p."""
        return fields[0][p], fields[1][p], fields[2][p], fields[3][p], fields[4][p], fields[5][p]

    @ti.func
    def hand(self, function: ti.template(), p, t, value):
        """Call the function."""
        function(self, p, value, 0 if ti.static(self.atomic) else t)

    @ti.func
    def each(self, function: ti.template(), p):
        """The function of p."""
        return function(p)

    @ti.func
    def gather(self, field: ti.template(), p, t):
        """What point p gathers."""
        return g2p.gather(self.particles, self.grid, self.shape, field, p, t)

    @ti.func
    def begin(self, low, high):
        """Nothing to do before the steps."""

    @ti.func
    def points_of(self, t, threads: ti.template()):
        """First of the points of thread t, and of those of the next."""
        count = self.particles.active[None]
        return t * count // threads, (t + 1) * count // threads

    @ti.func
    def scatter(self, run: ti.template(), t, threads: ti.template(), step, option: ti.template(), turn):
        """The phase that adds to the nodes, for the points of thread t, all in one turn."""
        first, last = self.points_of(t, threads)
        for p in range(first, last):
            run(self, p, t, step, option)

    @ti.func
    def row(self, run: ti.template(), eights: ti.template(), j, step, option: ti.template()):
        """The phase over nodes, for those of row j (`eights` is not for these)."""
        for i in range(self.grid.columns):
            run(self, i, j, step, option)

    @ti.func
    def read_sums(self, i, j, last: ti.template()):
        """Mass, momentum and force of node (i, j) from all copies, which are emptied (the mass only if `last`)."""
        k = j * self.grid.columns + i
        m, momentum, force = self.grid.mass[k], self.grid.momentum[k], self.grid.force[k]
        for copy in ti.static(range(1, self.grid.copies)):
            other = copy * self.grid.nodes + k
            m, momentum = m + self.grid.mass[other], momentum + self.grid.momentum[other]
            force = force + self.grid.force[other]
        for copy in ti.static(range(self.grid.copies)):
            other = copy * self.grid.nodes + k
            if ti.static(last):
                self.grid.mass[other] = 0.0
            self.grid.momentum[other] = ti.Vector([0.0, 0.0])
            self.grid.force[other] = ti.Vector([0.0, 0.0])
        return m, momentum[0], momentum[1], force[0], force[1]

    @ti.func
    def write_velocity(self, k, x, y, old):
        """Velocity (x, y) of node k, and its change from an old one."""
        self.grid.velocity[k] = ti.Vector([x, y])
        self.grid.change[k] = ti.Vector([x - old[0], y - old[1]])

    @ti.func
    def clear_axis(self, k, j):
        """Nothing crosses the axis at node k: no momentum and no force along x."""
        for copy in ti.static(range(self.grid.copies)):
            self.grid.momentum[copy * self.grid.nodes + k][0] = 0.0
            self.grid.force[copy * self.grid.nodes + k][0] = 0.0

    @ti.func
    def fold(self, k, image, j):
        """Add the mirrored sums of node `image` to those of node k, and empty them."""
        mirror, nothing = ti.Vector([-1.0, 1.0]), ti.Vector([0.0, 0.0])
        for copy in ti.static(range(self.grid.copies)):
            here, there = copy * self.grid.nodes + k, copy * self.grid.nodes + image
            self.grid.mass[here] = self.grid.mass[here] + self.grid.mass[there]
            self.grid.momentum[here] = self.grid.momentum[here] + mirror * self.grid.momentum[there]
            self.grid.force[here] = self.grid.force[here] + mirror * self.grid.force[there]
            self.grid.mass[there], self.grid.momentum[there], self.grid.force[there] = 0.0, nothing, nothing

    @ti.func
    def unfold(self, k, image):
        """Mirror the velocities of node k to node `image`."""
        mirror = ti.Vector([-1.0, 1.0])
        for velocity in ti.static(self.grid.velocities()):
            velocity[image] = mirror * velocity[k]
