"""The step on a processor's vector unit: eight points at once where formulas of points are evaluated, eight quantities
at once between a point and its nodes.

The formulas are those of phases.py and of the law; only who gathers and who scatters is written here. What makes it
fast: vectors of eight that stay vectors of the processor, points in the order of their cells, so that the sums of a run
of points with the same nodes stay in registers, and many steps in a launch.

The points are cut into strips, each with sums of its own, whose number does not depend on that of the threads: the
order of every sum, and with it every bit of the result, is the same for one thread and for two.
"""

import numpy as np
import taichi as ti

from taichi_silo.mpm.g2p import point_contributions, weights
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.grid_update import motion_of_node, pass_by
from taichi_silo.mpm.lane_maths import greatest
from taichi_silo.mpm.runtime import LANES, compiling_wide, eight, is_cpu, real

STRIPS = 2  # or as many as threads, if they are more
SORTED_FOR = 0.25  # of a cell: as far as points may move before they are sorted anew
NOTHING = 1e-200  # of a point's mass and volume: what fills up the last group
arrays_of_eight = ti.types.ndarray(eight, 1)


@ti.func
def along_x(s, g):
    """Weights along x of the eight slots of phases.py."""
    return eight(s, s, s, s, g, g, s, s)


@ti.func
def along_y(s, g):
    """Weights along y of the eight slots."""
    return eight(s, s, s, s, s, s, g, g)


@ti.data_oriented
class Lanes:
    """Runs the steps of a solver over groups of eight points; the solver's fields hold the state before and after.

    ==============  ===============  ===================================================================
    array of eight  shape            meaning
    ==============  ===============  ===================================================================
    points          group * record   the fields of eight points, one after the other
    sums            strip * node     what the points of a strip gave to a node, by slots
    nodal           node             what a point may take there: velocity, change, velocity, velocity
    ==============  ===============  ===================================================================

    """

    def __init__(self, solver):
        self.solver, self.particles, self.grid, self.shape = solver, solver.particles, solver.grid, solver.shape
        self.threads, self.barrier = solver.threads, solver.barrier
        self.strips = max(STRIPS, self.threads)
        self.points = ti.ndarray(eight, self.particles.groups * self.particles.record)
        self.sums = ti.ndarray(eight, self.strips * self.grid.nodes)
        self.sums.fill(0.0)
        self.nodal = ti.ndarray(eight, self.grid.nodes)
        self.nodal.fill(0.0)
        self.reach = ti.field(ti.i32, shape=(self.strips, 16))  # first and last row of nodes that a strip touched
        self.sorted = (-1, 0.0)  # revision of the particles, and how far points may have moved since [cells]
        self.compiled = False

    @property
    def waits(self) -> int:
        """How often the threads wait for each other in a step."""
        return 3 if self.solver.averaging.ACTIVE else 2

    @staticmethod
    def why_not(solver) -> str:
        """Why a solver cannot run on lanes; empty if it can."""
        if not is_cpu():
            return "it runs on a GPU"
        if real != ti.f64:
            return "it does not compute in f64"
        if solver.stress_update != "last":
            return f"its stress update is '{solver.stress_update}'"
        if solver.filter.ACTIVE:
            return "it filters stresses"
        if solver.transfer.SECOND_TRANSFER or solver.transfer.GRADIENT != "none":
            return f"its transfer is {solver.transfer}"
        if solver.grid.periodic:
            return "its grid is periodic"
        return ""

    def run(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        """Steps `done` to `done + count` of a schedule of `steps` (see `Solver.advance`)."""
        self._sort(count, dt, schedule)
        self.load()
        arrays, before = (self.points, self.sums, self.nodal), self.barrier.reserve(count * self.waits)
        given = *arrays, done, count, steps, dt, *schedule, before
        if self.compiled:
            self._steps(*given)
        else:
            with compiling_wide():
                self._steps(*given)
            self.compiled = True
        self._store(self.points, self.nodal)

    def load(self) -> None:
        """Take the state over from the fields."""
        self._load(self.points)

    # --- order --------------------------------------------------------------------------------------------------

    def _sort(self, count: int, dt: float, schedule) -> None:
        """Put the points in the order of their cells, unless they hardly moved since that was done."""
        revision, moved = self.sorted
        moved += 2.0 * count * dt * max(map(abs, schedule[2:4])) / self.grid.cell_size
        moved += count * 1e-4  # if something moves by itself faster than that, the order is not the best
        if revision == self.particles.revision and moved < SORTED_FOR:
            self.sorted = revision, moved
            return
        active = int(self.particles.active[None])
        place = self.particles.position.to_numpy()[:active]
        if np.isfinite(place).all():
            per_cell = 1.0 / self.grid.cell_size, 1.0 / (self.grid.cell_size * float(self.grid.stretch[0]))
            offset = self.shape.half_size if self.shape.NODES == 3 else 0.0
            # a lattice may lie on the edge of cells: round-off must not tear its rows apart
            cell = np.floor(place * per_cell - offset + 1e-9)
            order = np.lexsort((cell[:, 0], cell[:, 1])).astype(np.int32)
        else:
            order = np.arange(active, dtype=np.int32)
        full = np.full(self.particles.groups * LANES, self.particles.count, dtype=np.int32)
        full[:active] = order
        self.particles.order.from_numpy(full)
        self.sorted = self.particles.revision, 0.0

    @ti.kernel
    def _load(self, points: arrays_of_eight):
        for q in range(self.particles.groups * LANES):
            g, lane = q // LANES, q % LANES
            p, scale = self.particles.order[q], ti.cast(1.0, real)
            if p >= self.particles.active[None]:
                p, scale = self.particles.order[ti.max(self.particles.active[None] - 1, 0)], NOTHING
            for name in ti.static(self.particles.names):
                k = g * self.particles.record + ti.static(self.particles.begins[name])
                width = ti.static(self.particles.WIDTHS.get(name, 1))
                if ti.static(name in ("mass", "volume")):
                    points[k][lane] = scale * ti.static(self.particles.fields[name])[p]
                elif ti.static(width == 1):
                    points[k][lane] = ti.static(self.particles.fields[name])[p]
                else:
                    for c in ti.static(range(width)):
                        points[k + c][lane] = ti.static(self.particles.fields[name])[p][c]

    @ti.kernel
    def _store(self, points: arrays_of_eight, nodal: arrays_of_eight):
        for q in range(self.particles.active[None]):
            g, lane = q // LANES, q % LANES
            p = self.particles.order[q]
            for name in ti.static(self.particles.names):
                k = g * self.particles.record + ti.static(self.particles.begins[name])
                width = ti.static(self.particles.WIDTHS.get(name, 1))
                if ti.static(width == 1):
                    ti.static(self.particles.fields[name])[p] = points[k][lane]
                else:
                    for c in ti.static(range(width)):
                        ti.static(self.particles.fields[name])[p][c] = points[k + c][lane]
        for k in range(self.grid.nodes):
            for c in ti.static(range(2)):
                self.grid.velocity[k][c] = nodal[k][c]
                self.grid.change[k][c] = nodal[k][2 + c]

    # --- steps --------------------------------------------------------------------------------------------------

    @ti.kernel
    def _steps(
        self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, done: ti.i32, count: ti.i32,
        steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real, filling_drag: real, passed: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for t in range(self.threads):
            groups = (self.particles.active[None] + LANES - 1) // LANES
            first, last = t * self.strips // self.threads, (t + 1) * self.strips // self.threads
            low, high = t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads
            for number in range(count):
                step = self.solver.at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
                arrived = number * self.waits
                for strip in range(first, last):
                    begin, end = strip * groups // self.strips, (strip + 1) * groups // self.strips
                    self.scatter(points, sums, strip, begin, end, t)
                self.barrier.wait(passed, arrived)
                for j in range(low, high):
                    self.integrate_row(sums, nodal, j, step)
                self.barrier.wait(passed, arrived + 1)
                if ti.static(self.solver.surfaces.ACTIVE):
                    for j in range(low, high):
                        self.solver.surfaces.press_row(j, step.dt)
                begin, end = first * groups // self.strips, last * groups // self.strips
                for g in range(begin, end):
                    self.solver.update_point(points, g, t, step, self.gather(points, nodal, g, t), True, True)
                if ti.static(self.solver.averaging.ACTIVE):
                    self.barrier.wait(passed, arrived + 2)
                    for g in range(begin, end):
                        self.solver.update_stress(points, g, step, self.solver.averaging.mean_of_group(g))
                self.grid.follow(t, step)

    @ti.func
    def scatter(self, points: ti.template(), sums: ti.template(), strip, begin, end, t):
        """Particles to grid: what the points of groups `begin` to `end` give, into the sums of a strip."""
        lowest, highest = eight(self.grid.rows), eight(0.0)
        nothing = eight(0.0)
        c00, c01, c02 = nothing, nothing, nothing
        c10, c11, c12 = nothing, nothing, nothing
        c20, c21, c22 = nothing, nothing, nothing
        at, columns = -2, self.grid.columns  # nothing has been collected yet, and node 0 does not follow it
        for g in range(begin, end):
            given = point_contributions(self.particles, self.grid, self.solver.surroundings, points, g, t)
            for patch in ti.static(range(self.shape.PATCHES)):
                i, sx, gx, j, sy, gy = weights(self.particles, self.grid, self.shape, points, g, t, patch)
                lowest, highest = ti.min(lowest, j), ti.max(highest, j)
                first = j * columns + i
                for lane in range(LANES):
                    k = strip * self.grid.nodes + self.within(first[lane])
                    v = eight(
                        given[0][lane], given[1][lane], given[2][lane], given[3][lane], given[4][lane], given[5][lane],
                        given[6][lane], given[7][lane],
                    )  # fmt: skip
                    if ti.static(self.shape.NODES == 3):
                        # as long as the points have the same nodes, their sums stay here
                        if k == at + 1:
                            sums[at] = sums[at] + c00
                            sums[at + columns] = sums[at + columns] + c10
                            sums[at + 2 * columns] = sums[at + 2 * columns] + c20
                            c00, c10, c20 = c01, c11, c21
                            c01, c11, c21 = c02, c12, c22
                            c02, c12, c22 = nothing, nothing, nothing
                            at = k
                        if k != at:
                            self.flush(sums, at, c00, c01, c02, c10, c11, c12, c20, c21, c22)
                            c00, c01, c02 = nothing, nothing, nothing
                            c10, c11, c12 = nothing, nothing, nothing
                            c20, c21, c22 = nothing, nothing, nothing
                            at = k
                        x0, x1, x2 = (
                            along_x(sx[0][lane], gx[0][lane]), along_x(sx[1][lane], gx[1][lane]),
                            along_x(sx[2][lane], gx[2][lane]),
                        )  # fmt: skip
                        y = v * along_y(sy[0][lane], gy[0][lane])
                        c00, c01, c02 = c00 + x0 * y, c01 + x1 * y, c02 + x2 * y
                        y = v * along_y(sy[1][lane], gy[1][lane])
                        c10, c11, c12 = c10 + x0 * y, c11 + x1 * y, c12 + x2 * y
                        y = v * along_y(sy[2][lane], gy[2][lane])
                        c20, c21, c22 = c20 + x0 * y, c21 + x1 * y, c22 + x2 * y
                    else:
                        for b in ti.static(range(self.shape.NODES)):
                            y = v * along_y(sy[b][lane], gy[b][lane])
                            for a in ti.static(range(self.shape.NODES)):
                                node = k + b * columns + a
                                sums[node] = sums[node] + along_x(sx[a][lane], gx[a][lane]) * y
        self.flush(sums, at, c00, c01, c02, c10, c11, c12, c20, c21, c22)
        self.reach[strip, 0] = ti.cast(0.0 - greatest(0.0 - lowest), ti.i32)
        self.reach[strip, 1] = ti.cast(greatest(highest), ti.i32) + self.shape.NODES - 1

    @ti.func
    def within(self, first):
        """Number of the first node of a patch; one of the grid's even where the place of a point is no number."""
        span = ti.static((self.shape.NODES - 1) * (self.grid.columns + 1))
        return ti.max(0, ti.min(ti.cast(first, ti.i32), self.grid.nodes - 1 - span))

    @ti.func
    def flush(self, sums: ti.template(), k, c00, c01, c02, c10, c11, c12, c20, c21, c22):
        """Add nine nodes' sums from node k on."""
        if k >= 0:
            middle, top = k + self.grid.columns, k + 2 * self.grid.columns
            sums[k], sums[k + 1], sums[k + 2] = sums[k] + c00, sums[k + 1] + c01, sums[k + 2] + c02
            sums[middle], sums[middle + 1], sums[middle + 2] = (
                sums[middle] + c10, sums[middle + 1] + c11, sums[middle + 2] + c12
            )  # fmt: skip
            sums[top], sums[top + 1], sums[top + 2] = sums[top] + c20, sums[top + 1] + c21, sums[top + 2] + c22

    @ti.func
    def integrate_row(self, sums: ti.template(), nodal: ti.template(), j, step):
        """Motion of the nodes of row j; empties the sums for the next step."""
        s = self.solver
        if ti.static(s.MIRRORED):
            self.fold(sums, j)
        for i in range(self.grid.columns):
            k = j * self.grid.columns + i
            total = eight(0.0)
            for strip in ti.static(range(self.strips)):
                if self.reach[strip, 0] <= j and j <= self.reach[strip, 1]:
                    total = total + sums[strip * self.grid.nodes + k]
                    sums[strip * self.grid.nodes + k] = eight(0.0)
            m = total[0]
            if m > 0.0:
                per_m = 1.0 / m
                old = total[1] * per_m, total[2] * per_m
                push = (total[3] + total[4] + total[6]) * per_m, (total[5] + total[7]) * per_m
                x, y = motion_of_node(
                    self.grid, s.walls, s.surfaces, s.control, s.impulses, s.down, i, j, step, m, old, push, False
                )
                nodal[k] = eight(x, y, x - old[0], y - old[1], x, y, x, y)
            else:
                pass_by(self.grid, s.surfaces, k)
        if ti.static(s.MIRRORED):
            axis = self.grid.node(self.grid.columns - 1 - MARGIN, j)
            for n in ti.static(range(1, MARGIN + 1)):
                nodal[axis + n] = nodal[axis - n] * eight(-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0)

    @ti.func
    def fold(self, sums: ti.template(), j):
        """Sums of row j beyond an axis of symmetry to their images, turned round; nothing crosses it (half.py)."""
        turned = eight(1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0)
        for strip in ti.static(range(self.strips)):
            if self.reach[strip, 0] <= j and j <= self.reach[strip, 1]:
                axis = strip * self.grid.nodes + self.grid.node(self.grid.columns - 1 - MARGIN, j)
                sums[axis] = sums[axis] * (0.5 + 0.5 * turned)
                for n in ti.static(range(1, MARGIN + 1)):
                    sums[axis - n] = sums[axis - n] + sums[axis + n] * turned
                    sums[axis + n] = eight(0.0)

    @ti.func
    def gather(self, points: ti.template(), nodal: ti.template(), g, t):
        """Grid to particles: the eight slots that the points of group g take, and the first once more (S v_x)."""
        t0, t1, t2, t3 = eight(0.0), eight(0.0), eight(0.0), eight(0.0)
        t4, t5, t6, t7 = eight(0.0), eight(0.0), eight(0.0), eight(0.0)
        for patch in ti.static(range(self.shape.PATCHES)):
            i, sx, gx, j, sy, gy = weights(self.particles, self.grid, self.shape, points, g, t, patch)
            first = j * self.grid.columns + i
            for lane in range(LANES):
                k = self.within(first[lane])
                total = eight(0.0)
                for b in ti.static(range(self.shape.NODES)):
                    row = eight(0.0)
                    for a in ti.static(range(self.shape.NODES)):
                        row = row + nodal[k + b * self.grid.columns + a] * along_x(sx[a][lane], gx[a][lane])
                    total = total + row * along_y(sy[b][lane], gy[b][lane])
                t0[lane], t1[lane], t2[lane], t3[lane] = (
                    t0[lane] + total[0], t1[lane] + total[1], t2[lane] + total[2], t3[lane] + total[3]
                )  # fmt: skip
                t4[lane], t5[lane], t6[lane], t7[lane] = (
                    t4[lane] + total[4], t5[lane] + total[5], t6[lane] + total[6], t7[lane] + total[7]
                )  # fmt: skip
        return t0, t1, t2, t3, t4, t5, t6, t7, t0
