"""A filter of the points' stresses that acts by strain: what varies from cell to cell fades as the sand is sheared.

Nodes feel sum_p V_p sigma_p grad S_ip alone. Patterns of stress that this sum does not feel, of points within a cell or
of cells in turn, are held by the law's memory only, and sheared sand has little of it: near the critical state its
pressure follows from the void ratio, of which a few thousandths are the whole pressure. Left alone they grow until
every second point carries twice the mean stress and the others none.

Let P take stresses to the nodes with quadratic weights, volume-weighted means at the centroids of what they are means
of, and back with the slope that they have there. P leaves linear fields as they are, at walls, free surfaces and
between scattered points too, and takes out what alternates between points of a cell, or between cells. The filter
subtracts a share of what four passes of 1 - P leave,

    sigma_p <- sigma_p - (1 - exp(-m_p gamma_p / STRAIN)) [(1 - P)^4 sigma]_p

where gamma_p is the path length of the point's strain since the filter's last turn, and m_p = 1 - exp(-(l_p / l)^2),
l_p being its whole path, grows as the sand forgets. Nothing happens to sand at rest, to a body that only moves, to an
elastic one, nor, but for parts in a thousand, to sand that is being filled, and the error is of eighth order in the
cell size. Sand that is as dense as it can be keeps its stress, too (`several.room`): that alone keeps a point from
being packed further, at the edge of an outlet.

The filter must not act earlier. In hoppers and beside bodies nodes need stresses that vary from cell to cell; sand that
loses them strains until it has them again, loses them again, and creeps: the softer the sand, the more. There the
filter waits for flow, and leaves what nodes feel (`felt_part`); with one point a cell such a scene has none
(`scene.stress_filter`). What nodes feel is not left everywhere, as the stresses of two rows of points in a cell part in
a shear zone, which nodes do feel: a layer then resists 2 % too much on cells as wide as its length, and 0.5 % without.

What P does not know at all fades as exp(-m gamma / STRAIN) whatever the turns; what it half knows fades the more, the
more turns share a strain, so turns follow each other by the way of the points (`TURN`), whatever the time step.
"""

from typing import Any

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.executors import Phase
from taichi_silo.mpm.felt_part import FeltPart
from taichi_silo.mpm.field_memory import present, put, values
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.several import admissible, room
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.patch_passes import NOWHERE, PatchPasses
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd.group_passes import GroupPasses
from taichi_silo.mpm.simd.lane_maths import exp_minus
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight, eight

STRAIN = 3e-4  # over which a pattern falls to 1 / e
FORGETS = 0.02  # l: path of the strain, over which sand forgets its stress
TURN = 3e-3  # of a cell: way of the fastest point between two turns of the filter
MOST_STEPS = 2000  # between them
FINITE = 1e30  # a larger stress [Pa] is none
MOST = 32.0  # strains over which something fades that are counted


@ti.data_oriented
class PatchFilter:
    """The filter, over patches of three nodes an axis.

    Parameters
    ----------
    particles, grid, law : of the solver.
    mirrored : whether the grid's last column before its margin is an axis of symmetry (see `mirrored_solver`).
    felt : of the same particles, if what nodes feel is not to be taken out.

    """

    ACTIVE = True
    BETWEEN_LAUNCHES = True

    def __init__(
        self, particles: Particles, grid: Grid, law: Law, mirrored: bool = False, felt: FeltPart | None = None
    ):
        self.felt, self.waits = felt, felt is not None  # for flow
        self.particles, self.grid, self.law, self.alone = particles, grid, law, runtime.alone()
        self.path = ti.field(real, shape=particles.count)  # of the strain at the last turn
        self.ACTIVE = self.BETWEEN_LAUNCHES = getattr(law, "FORGETS", True)
        self.revision, self.way, self.steps = -1, 0.0, 0  # of the points; way [cells] and steps since the last turn
        self.passes = PatchPasses(particles, grid, mirrored)
        self.executor: Any = None  # of the vector unit,
        self.groups: Any = None  # and the passes on its points

    def work_on(self, executor: Any) -> None:
        """Work where the vector unit holds the points; if nodes are asked what they feel, in its arrays only."""
        self.executor = executor
        if self.felt:
            self.felt.layout = self.passes.layout = executor.layout
            self.passes.points, self.passes.sums, self.passes.means = executor.arrays
            self.passes.barrier = executor.loop.barrier
        else:
            self.groups = GroupPasses(self, executor, self.passes.mirrored)

    def phases(self) -> list[Phase]:
        """None: it acts between launches."""
        return []

    def begin(self) -> None:
        """Count the strain of each point from now on, if the points are others than before."""
        if self.revision != self.particles.revision:
            self.revision, self.way, self.steps = self.particles.revision, 0.0, 0
            put(self.path, self.particles.array("path"), self.particles.number)

    def keep(self, stayed: np.ndarray) -> None:
        """Go on with those of the points (bool) that have stayed; the others have just been taken out."""
        if self.revision == self.particles.revision - 1:
            self.revision = self.particles.revision
            put(self.path, values(self.path, len(stayed))[stayed], int(stayed.sum()))

    def steps_within(self, speed_m_per_s: float, dt: float) -> int:
        """How many steps at this speed may pass before the next turn."""
        way = speed_m_per_s * dt / self.grid.cell_size
        return max(1, int(min(MOST_STEPS - self.steps, (TURN - self.way) / (way + 1e-300) + 1e-6)))

    def passed(self, steps: int, speed_m_per_s: float, dt: float) -> None:
        """So many steps have passed; a turn if it is due."""
        self.steps += steps
        self.way += steps * speed_m_per_s * dt / self.grid.cell_size
        next_way = speed_m_per_s * dt / self.grid.cell_size
        if self.steps >= MOST_STEPS or self.way + next_way > TURN * (1.0 + 1e-6):
            self._turn()
            self.way, self.steps = 0.0, 0

    def state(self) -> dict:
        """What outlives a launch, for a checkpoint."""
        return {"path": present(self.path), "way": self.way, "steps": self.steps}

    def restore(self, state: dict | None) -> None:
        """Go on from the points that are there now and what `state` gave; without it strain is not counted yet."""
        self.revision = -1
        if state is not None:
            put(self.path, state["path"])
            self.revision, self.way, self.steps = self.particles.revision, state["way"], state["steps"]

    def turn(self) -> None:
        """Let fade what is to fade; the fields of the points have it then."""
        self._turn()
        if self.executor:
            self.executor.hand_back()

    def _turn(self) -> None:
        if self.groups:
            self.executor.change(self.groups.turn)
            return
        if self.executor:
            self.executor.hand_back()
            self.executor.lend()
        self.passes.hold()
        self._read(self.passes.points)
        self.passes.run()
        if self.felt:
            self._finish(self.passes.points, True, False)
            self.felt.take_out(self.passes.points)
        self._finish(self.passes.points, not self.felt, True)

    # --- fields, whose components cannot be had where vectors stay vectors of the processor ------------------------

    @ti.kernel
    def _read(self, points: arrays_of_eight):
        ti.loop_config(serialize=self.alone)
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            s = self.particles.stress[p]
            x = self.particles.position[p][0] / self.grid.cell_size
            y = self.particles.position[p][1] / self.grid.cell_height(0)
            if not (ti.abs(s).sum() + ti.abs(x) < FINITE and ti.abs(y) < -NOWHERE):
                s, x, y = ti.Vector([0.0, 0.0, 0.0, 0.0]), 0.0, NOWHERE
            points[p] = eight(s[0], s[1], s[2], s[3], x, y, 0.0, 0.0)

    @ti.kernel
    def _finish(self, points: arrays_of_eight, weighs: ti.template(), takes_out: ti.template()):
        ti.loop_config(serialize=self.alone)
        for p in range(self.particles.places()):
            if self.particles.is_there(p):
                if ti.static(weighs):
                    self._weigh(points, p)
                if ti.static(takes_out):
                    self._take_out(points, p)

    @ti.func
    def _weigh(self, points: ti.template(), p):
        """Of what the passes left of point p the share that is to be taken out, and the room it has."""
        s = self.particles.read("stress", p)
        if points[p][5] > NOWHERE:
            e = self._void_ratio(self.particles, p)
            share = self._share(self.particles, p, s, e, self.path[p])
            for c in ti.static(range(4)):
                points[p][c] *= share
            points[p][6] = room(self.law, self.particles, p, s, e)
        self.path[p] = self.particles.path[p]

    @ti.func
    def _take_out(self, points: ti.template(), p):
        """The stress of point p without it."""
        if points[p][5] > NOWHERE:
            s, out = self.particles.stress[p], points[p]
            rest = s[0] - out[0], s[1] - out[1], s[2] - out[2], s[3] - out[3]
            e = self._void_ratio(self.particles, p)
            self.particles.write("stress", p, admissible(self.law, self.particles, p, rest, e))

    @ti.func
    def finish_group(self, store: ti.template(), g, left, sound):
        """Both for a group of eight of a store, where its points are sound."""
        before = eight(0.0)
        for lane in ti.static(range(LANES)):
            before[lane] = self.path[store.number(g, lane)]
        s0, s1, s2, s3 = store.read("stress", g)
        e = self._void_ratio(store, g)
        share = self._share(store, g, (s0, s1, s2, s3), e, before)
        rest = s0 - share * left[0], s1 - share * left[1], s2 - share * left[2], s3 - share * left[3]
        n0, n1, n2, n3 = admissible(self.law, store, g, rest, e)
        store.write("stress", g, (
            ti.select(sound, n0, s0), ti.select(sound, n1, s1), ti.select(sound, n2, s2), ti.select(sound, n3, s3),
        ))  # fmt: skip
        path = store.read("path", g)
        for lane in ti.static(range(LANES)):
            self.path[store.number(g, lane)] = path[lane]

    @ti.func
    def _share(self, points: ti.template(), p, stress, e, path_before):
        """Of what the passes have left of point p, or of a group of a store, the share that is taken out."""
        path = points.read("path", p)
        forgets = 1.0 - exp_minus(path * path * (1.0 / FORGETS**2), MOST)
        share = 1.0 - exp_minus(forgets * (path - path_before) * (1.0 / STRAIN), MOST)
        return share * room(self.law, points, p, stress, e)

    @ti.func
    def _void_ratio(self, points: ti.template(), p):
        return points.read("volume", p) * self.law.grain_density / points.read("mass", p) - 1.0
