"""The patch filter where the vector unit holds the points: a turn is one launch, over groups of eight.

The passes are those of `patch_passes`, where it is said what P does. Points keep nothing here: what the passes so far
have left of a stress is found anew in each, as the stress less what all means so far give back.
"""

from typing import Any

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.patch_passes import LEAST_SPREAD, PASSES, STRESS, fold
from taichi_silo.mpm.point_weights import weights_at
from taichi_silo.mpm.shapes.ugimp import UniformGimp
from taichi_silo.mpm.simd.lane_maths import greatest
from taichi_silo.mpm.simd.store import HALVES, Groups
from taichi_silo.mpm.simd.vectors import arrays_of_eight, eight, transposed

FINITE = 1e60  # a stress [Pa] or place [cells] whose square is above is none


@ti.data_oriented
class GroupPasses:
    """A turn of the filter on the arrays of an executor, a launch of all its threads.

    Parameters
    ----------
    filtering : the filter, which says what becomes of a stress (`finish_group`) and holds the path of the strain.
    executor : whose points and nodes these are.
    mirrored : whether the grid's last column before its margin is an axis of symmetry (see `mirrored_solver`).

    ==============  =================================================================================================
    array of eight  meaning
    ==============  =================================================================================================
    sums            what points gave to a node: weight times what is left (4), weight, its moments (x, y) [cells], 0
    nodal           of all passes: sum of the means (4); 1 / weight (0 without any), centroid (x, y) [cells], 1 or 0
    ==============  =================================================================================================

    """

    def __init__(self, filtering: Any, executor: Any, mirrored: bool):
        self.filtering, self.mirrored = filtering, mirrored
        self.layout, self.grid, self.particles = executor.layout, executor.grid, executor.particles
        self.threads, self.alone, self.barrier = executor.threads, executor.alone, executor.loop.barrier
        self.shape = UniformGimp(0.5)
        # from where places are measured, so that those of mirror images have the other sign
        self.axis = float(self.grid.columns - 1 - 2 * MARGIN) if mirrored else 0.0

    def turn(self, points: ti.Ndarray, sums: ti.Ndarray, nodal: ti.Ndarray) -> None:
        """Filter the stresses of the points; sums and nodal velocities are 0 afterwards."""
        self._turn(points, sums, nodal, self.barrier.reserve((PASSES + 1) * (HALVES + 1)))

    @ti.kernel
    def _turn(self, points: arrays_of_eight, sums: arrays_of_eight, nodal: arrays_of_eight, passed: ti.i32):
        ti.loop_config(block_dim=1, serialize=self.alone)
        for t in range(self.threads):
            for store in ti.static([Groups(self.layout, points, sums, nodal)]):
                store.align()
                low, high = t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads
                self._clear(sums, nodal, low, high)
                for number in range(PASSES + 1):
                    for turn in range(HALVES):
                        self.barrier.wait(passed, number * (HALVES + 1) + turn)
                        first, last = store.strips_of(t, self.threads)
                        for strip in range(first, last):
                            if self.layout.half[strip] == turn:
                                store.scatter_strip(strip, t, self, number)
                    self.barrier.wait(passed, number * (HALVES + 1) + HALVES)
                    if number < PASSES:
                        for j in range(low, high):
                            self._take_means(sums, nodal, j, number)
                    else:
                        self._clear(sums, nodal, low, high)

    @ti.func
    def _clear(self, sums: ti.template(), nodal: ti.template(), low, high):
        """Set the nodes of some rows to 0."""
        for k in range(low * self.grid.columns, high * self.grid.columns):
            sums[k], nodal[k] = eight(0.0), eight(0.0)

    # --- of a group, as of a step (`store.OfStep`) ------------------------------------------------------------------

    @ti.func
    def given(self, store: ti.template(), g, t, number):
        """Slots that group g gives in a pass: weight times what is left, weight, moments. The last takes that out."""
        s0, s1, s2, s3 = store.read("stress", g)
        sound, x, y = self._place(store, g, t)
        r0, r1, r2, r3 = s0, s1, s2, s3
        if number > 0:
            r0, r1, r2, r3 = self._left(store, (s0, s1, s2, s3), g, t)
        if number == PASSES:
            self.filtering.finish_group(store, g, (r0, r1, r2, r3), sound)
        zero = eight(0.0)
        r0, r1, r2, r3 = (
            ti.select(sound, r0, zero), ti.select(sound, r1, zero), ti.select(sound, r2, zero),
            ti.select(sound, r3, zero),
        )  # fmt: skip
        weight = ti.select(sound, store.read("volume", g), zero)
        return weight * r0, weight * r1, weight * r2, weight * r3, weight, weight * x, weight * y, zero

    @ti.func
    def weights(self, store: ti.template(), g, t, patch: ti.template()):
        """Columns and weights of quadratic patches (see `point_weights`)."""
        _, x, y = self._place(store, g, t)
        zero = eight(0.0)
        return weights_at(self.grid, self.shape, patch, x + self.axis, y, (zero, zero, zero, zero))

    @ti.func
    def along_x(self, s, g):
        """All slots have the weight of the node."""
        return eight(s)

    @ti.func
    def along_y(self, s, g):
        """The same along y."""
        return eight(s)

    @ti.func
    def _place(self, store: ti.template(), g, t):
        """Whether points are finite, and their place from the axis of symmetry [cells], 0 if they are not."""
        s0, s1, s2, s3 = store.read("stress", g)
        x, y = store.read("position", g)
        x, y = x * (1.0 / self.grid.cell_size), y * (1.0 / self.grid.cell_height(t))
        sound = s0 * s0 + s1 * s1 + s2 * s2 + s3 * s3 + x * x + y * y < FINITE
        return sound, ti.select(sound, x - self.axis, eight(0.0)), ti.select(sound, y, eight(0.0))

    @ti.func
    def _left(self, store: ti.template(), stress, g, t):
        """Stresses of eight points less what the means give back at a point.

        Summed over the nodes by their weights (s) the means are right at the centroid of the centroids; summed by the
        slopes of the weights (dx, dy) they give the slope there: see `PatchPasses`.
        """
        _, x, y = self._place(store, g, t)
        i, sx, gx, j, sy, gy = self.weights(store, g, t, 0)
        s, dx, dy = self._from_nodes(store, j * self.grid.columns + i, sx, gx, sy, gy)
        off_x, off_y = s[5] - s[7] * x, s[6] - s[7] * y  # from the point to the centroid of the centroids
        xx, xy = dx[5] - dx[7] * x, dx[6] - dx[7] * y  # spread of the centroids
        yx, yy = dy[5] - dy[7] * x, dy[6] - dy[7] * y
        zero, one = eight(0.0), eight(1.0)
        area = xx * yy - xy * yx
        wide = area > LEAST_SPREAD * LEAST_SPREAD
        per_area = 1.0 / ti.select(wide, area, one)
        tx, ty = (yy * off_x - yx * off_y) * per_area, (xx * off_y - xy * off_x) * per_area
        if greatest(ti.select(wide, zero, one)) > 0.0:  # strands among them
            tx = ti.select(wide, tx, ti.select(xx > LEAST_SPREAD, off_x / xx, zero))
            ty = ti.select(wide, ty, ti.select(yy > LEAST_SPREAD, off_y / yy, zero))
        return (
            stress[0] - (s[0] - tx * dx[0] - ty * dy[0]), stress[1] - (s[1] - tx * dx[1] - ty * dy[1]),
            stress[2] - (s[2] - tx * dx[2] - ty * dy[2]), stress[3] - (s[3] - tx * dx[3] - ty * dy[3]),
        )  # fmt: skip

    @ti.func
    def _from_nodes(self, store: ti.template(), first, sx, gx, sy, gy):
        """What eight points gather, by weights, by their slopes along x, and along y: eight slots of each."""
        s0, x0, y0 = self._from_patch(store, 0, first, sx, gx, sy, gy)
        s1, x1, y1 = self._from_patch(store, 1, first, sx, gx, sy, gy)
        s2, x2, y2 = self._from_patch(store, 2, first, sx, gx, sy, gy)
        s3, x3, y3 = self._from_patch(store, 3, first, sx, gx, sy, gy)
        s4, x4, y4 = self._from_patch(store, 4, first, sx, gx, sy, gy)
        s5, x5, y5 = self._from_patch(store, 5, first, sx, gx, sy, gy)
        s6, x6, y6 = self._from_patch(store, 6, first, sx, gx, sy, gy)
        s7, x7, y7 = self._from_patch(store, 7, first, sx, gx, sy, gy)
        return (
            transposed(s0, s1, s2, s3, s4, s5, s6, s7), transposed(x0, x1, x2, x3, x4, x5, x6, x7),
            transposed(y0, y1, y2, y3, y4, y5, y6, y7),
        )  # fmt: skip

    @ti.func
    def _from_patch(self, store: ti.template(), lane: ti.template(), first, sx, gx, sy, gy):
        """The same of one point."""
        s, dx, dy = eight(0.0), eight(0.0), eight(0.0)
        k = store.within(first[lane], 3)
        for b in ti.static(range(3)):
            row = k + b * self.grid.columns
            n0, n1, n2 = store.nodal[row], store.nodal[row + 1], store.nodal[row + 2]
            along = n0 * sx[0][lane] + n1 * sx[1][lane] + n2 * sx[2][lane]
            slope = n0 * gx[0][lane] + n1 * gx[1][lane] + n2 * gx[2][lane]
            s, dy = s + along * sy[b][lane], dy + along * gy[b][lane]
            dx = dx + slope * sy[b][lane]
        return s, dx, dy

    @ti.func
    def _take_means(self, sums: ti.template(), nodal: ti.template(), j, number):
        """Of row j, the means of what a pass has left, added to those of the passes before; the sums are emptied."""
        if ti.static(self.mirrored):
            fold(self.grid, sums, j)
        for k in range(j * self.grid.columns, (j + 1) * self.grid.columns):
            total = sums[k]
            sums[k] = eight(0.0)
            if number == 0 and total[4] > 0.0:
                per_weight = 1.0 / total[4]
                nodal[k] = eight(0.0, 0.0, 0.0, 0.0, per_weight, total[5] * per_weight, total[6] * per_weight, 1.0)
            nodal[k] = nodal[k] + eight(*ti.static(STRESS)) * total * nodal[k][4]
