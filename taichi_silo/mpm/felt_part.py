"""What nodes feel of a pattern of point stresses, and how it is taken out of the pattern.

Nodes feel of a pattern d the forces f_i = sum_p V_p d_p grad S_ip. The nearest pattern that they do not feel, by least
squares weighted with V_p / r_p, is

    d_p - r_p (B w)_p,   (B w)_p = sym sum_i w_i (x) grad S_ip,   K w = f

r B w is the stress of an elastic body of stiffness r_p under the forces f, K its stiffness; r_p is the room that a
point has (`several.room`), so that sand as dense as it can be gives no way. Conjugate gradients find w; all nodes stand
on a soft bed, which leaves those alone that hardly touch sand.

With d = s q, shares s of the patterns q, taking that is the change of the stresses nearest to -q where s is 1 and to 0
where it is 0: where all have room, of all changes that no node feels it makes
sum V (s |change + q|^2 + (1 - s) |change|^2) least. So sand that is not sheared gives a little way to its neighbours.
"""

import copy
from typing import Any, NamedTuple

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.cell_lists import CellLists
from taichi_silo.mpm.contracts import Shape
from taichi_silo.mpm.field_memory import put, values
from taichi_silo.mpm.field_store import Fields
from taichi_silo.mpm.g2p import gradient_of
from taichi_silo.mpm.geometry import Axisymmetric, PlaneStrain
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.one_node import take
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.patch_passes import NOWHERE, TURNS
from taichi_silo.mpm.simd.store import STRIPS
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight

LEFT = 0.05  # of the forces, weighted by the nodes' stiffness, at which conjugate gradients stop,
STEPS = 40  # or after so many steps
BED = 1e-7  # stiffness of the bed, of that of the stiffest node


class Given(NamedTuple):
    """What points give: the forces of the patterns in an array, or of the strains of a displacement of the nodes."""

    points: Any
    strained: bool


@ti.data_oriented
class FeltPart:
    """Takes it out of what stands in an array of eight, a row a point (see `PatchPasses`); slot 6 holds r.

    The grid must stand still and have no axis of symmetry.
    """

    def __init__(self, particles: Particles, grid: Grid, shape: Shape, geometry: PlaneStrain | Axisymmetric):
        self.particles, self.geometry = particles, geometry
        self.grid = copy.copy(grid)  # with sums of its own: `mass` is the trace of a node's stiffness, `velocity` is w
        self.grid.copies, self.grid.mass = 1, None
        self.grid.hold()
        self.store = Fields(particles, self.grid, shape, False)
        self.shared = not runtime.is_cpu()
        self.lists: Any = CellLists(particles, self.grid, shape) if self.shared else None
        self.layout: Any = None  # of the vector unit

    def take_out(self, points: ti.Ndarray) -> None:
        """Leave of the patterns in `points` what nodes do not feel."""
        if self.shared:
            self.lists.fill(0)
        rest = self._forces(points, False)
        weight = values(self.grid.mass)
        put(self.grid.mass, 0.0)
        bed = BED * weight.max()
        per_weight = 1.0 / (weight + bed + 1e-300)[:, None]
        w, along, last = 0.0 * rest, 0.0 * rest, 1.0
        size = first = float((rest * per_weight * rest).sum())
        for _ in range(STEPS):
            if size <= LEFT**2 * first:
                break
            along = rest * per_weight + size / last * along
            put(self.grid.velocity, along)
            resistance = self._forces(points, True) + bed * along
            way = size / float((along * resistance).sum())
            w += way * along
            rest -= way * resistance
            last, size = size, float((rest * per_weight * rest).sum())
        put(self.grid.velocity, w)
        self._take(points)

    def _forces(self, points: ti.Ndarray, strained: bool) -> np.ndarray:
        """Forces (node, 2) of the patterns, or of the strains of what stands in `velocity`."""
        for turn in range(TURNS if self.layout else 1):
            self._sum(points, strained, turn)
        found = values(self.grid.force)
        put(self.grid.force, 0.0)
        return found

    @ti.kernel
    def _sum(self, points: arrays_of_eight, strained: ti.template(), turn: ti.i32):
        if ti.static(self.shared):
            for k in range(self.grid.nodes):
                for given in ti.static([Given(points, strained)]):
                    take(self.store, self.lists, k, 0, self._give, 0, given)
        elif ti.static(not self.layout):
            ti.loop_config(serialize=True)
            for p in range(self.particles.active[None]):
                self._give_of(p, points, strained)
        else:  # strips of a turn share no nodes
            ti.loop_config(block_dim=1)
            for strip in range(STRIPS):
                if self.layout.half[strip] == turn:
                    for q in range(LANES * self.layout.first[strip], LANES * self.layout.first[strip + 1]):
                        if self.layout.order[q] < self.particles.active[None]:
                            self._give_of(self.layout.order[q], points, strained)

    @ti.kernel
    def _take(self, points: arrays_of_eight):
        for p in range(self.particles.places()):
            if self.particles.is_there(p):
                strain = self._strain(p)
                for c in ti.static(range(4)):
                    points[p][c] -= points[p][6] * strain[c]

    @ti.func
    def _strain(self, p):
        """Strain (xx, yy, zz, xy) at point p."""
        gathered = self.store.gather(self.grid.velocity, p, 0)
        xx, xy, yx, yy, hoop = gradient_of(self.store, self.grid, self.geometry, p, 0, gathered)
        return xx, yy, hoop, 0.5 * (xy + yx)

    @ti.func
    def _give_of(self, p, points: ti.template(), strained: ti.template()):
        for given in ti.static([Given(points, strained)]):
            self._give(self.store, p, 0, 0, given)

    @ti.func
    def _give(self, store: ti.template(), p, t, step, given: ti.template()):
        """What point p gives to its nodes: the force of its strain, or of its pattern and its part of the traces."""
        if given.points[p][5] > NOWHERE:
            pattern = given.points[p]
            xx, yy, zz, xy = pattern[0], pattern[1], pattern[2], pattern[3]
            volume, room = store.read("volume", p), given.points[p][6]
            if ti.static(given.strained):
                xx, yy, zz, xy = self._strain(p)
                xx, yy, zz, xy = room * xx, room * yy, room * zz, room * xy
            per_dx, per_dy, per_x = 1.0 / self.grid.cell_size, 1.0 / self.grid.cell_height(0), 0.0 * volume
            if ti.static(self.geometry.HOOP):
                per_x = 1.0 / store.read("position", p)[0]
            for patch in ti.static(store.patches()):
                i, sx, gx, j, sy, gy = store.touched(p, t, patch)
                for b in ti.static(range(len(sy))):
                    for a in ti.static(range(len(sx))):
                        k = self.grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)
                        s, dx, dy = sx[a] * sy[b] * per_x, gx[a] * sy[b] * per_dx, sx[a] * gy[b] * per_dy
                        force = ti.Vector([dx * xx + dy * xy + s * zz, dx * xy + dy * yy])
                        store.add(self.grid.force, k, volume * force)
                        if ti.static(not given.strained):
                            store.add(self.grid.mass, k, room * volume * (dx * dx + dy * dy + s * s))
