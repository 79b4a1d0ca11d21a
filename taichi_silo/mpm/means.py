"""What a mean over neighbours rests on: places and volumes of points as they were when it was built."""

from collections.abc import Sequence

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.contracts import Kernel
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real


@ti.data_oriented
class Means:
    """A mean over the neighbours of each point, normalised by their weights; subclasses say how it is summed.

    In a step `give(store, p, value, copy)` hands in the value of each point (to a copy of its own strip of points),
    the functions (j) of `passes` run one after the other, each over all of its `rows`, and `mean(p)` then is the mean
    around point number p.

    Parameters
    ----------
    kernel : with `weight(distance)`, before normalisation.
    particles : the points.
    rigid_planes : (axis, side, coordinate [m]) of planes beyond which nothing strains, yet counts: the kernel's share
        beyond them joins the sum of weights. `side` is the sign of the normal out of the points.
    alike_along_x : whether every field is alike along x, as in a periodic strip: distances are then along y only, which
        is what remains of a Gaussian over the whole plane.

    Raises
    ------
    ValueError
        if the kernel's length is not above 0.

    Attributes
    ----------
    builds : how often it was built.
    revision : of the particles that it was built from, -1 at first.
    origin : positions and volumes of the points that it was built from.

    """

    def __init__(
        self, kernel: Kernel, particles: Particles, rigid_planes: Sequence[tuple[int, int, float]], alike_along_x: bool
    ):
        if not kernel.length_m > 0.0:
            raise ValueError(f"characteristic length is {kernel.length_m} m; it must be above 0")
        self.kernel, self.particles, self.rigid_planes = kernel, particles, tuple(rigid_planes)
        self.counts = (0.0, 1.0) if alike_along_x else (1.0, 1.0)  # how much of x and y a distance counts
        self.serial = runtime.is_cpu()
        self.builds, self.revision = 0, -1
        self.origin: dict[str, np.ndarray] = {}
        self.place = ti.Vector.field(2, real, shape=particles.count)  # of the points when it was built [m]
        self.sand = ti.field(real, shape=particles.count)  # share of the kernel on this side of the rigid planes

    rows, copies, reach_m = 0, 1, 0.0  # the last: between points that add to a common node of the passes, at most

    def hold(self, copies: int) -> None:
        """Have so many copies of what points give, one for each that adds to it without waiting for the others."""

    def passes(self) -> tuple:
        """None: values that have been given are all that `mean` needs."""
        return ()

    def update(self, allowed_m: float) -> None:
        """Build anew if these particles never were in it, or a point has moved further than allowed [m]."""
        if self.revision != self.particles.revision or self._moved() > allowed_m:
            self.build()

    def forget(self) -> None:
        """Be built at the next update."""
        self.revision = -1

    def build(self) -> None:
        """Build from the points as they are now; points whose place is no number leave it as it is."""
        place = self.particles.array("position")
        if not np.isfinite(place).all():
            return  # the guard will stop the run
        self.origin = {"position": place, "volume": self.particles.array("volume")}
        put(self.sand, self._share_of_sand(place * self.counts), len(place))
        self._note_places()
        self._build(place * self.counts)
        self.builds += 1
        self.revision = self.particles.revision

    def _build(self, place: np.ndarray) -> None:
        """Build from points at `place`, coordinates that do not count being 0."""
        raise NotImplementedError

    def _share_of_sand(self, place: np.ndarray) -> np.ndarray:
        """Share of the kernel around each place that lies on the points' side of all rigid planes."""
        beyond = np.zeros((2, len(place)))  # of planes across each axis: of parallel ones, the shares add up
        for axis, side, coordinate in self.rigid_planes:
            distance = side * (coordinate - place[:, axis])
            near = distance < self.kernel.radius
            beyond[axis, near] += [self.kernel.beyond(value) for value in distance[near]]
        return np.prod(1.0 - beyond, axis=0)

    @ti.func
    def add(self, sums: ti.template(), k, value):
        """To entry k of a sum, beside a step (see `field_store`)."""
        if ti.static(self.serial):
            sums[k] = sums[k] + value
        else:
            sums[k] += value

    @ti.func
    def _distance(self, a, b):
        return ((a - b) * ti.Vector(self.counts)).norm()

    @ti.kernel
    def _note_places(self):
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            self.place[p] = self.particles.position[p]

    @ti.kernel
    def _moved(self) -> real:
        most = 0.0
        for p in range(self.particles.places()):
            if not self.particles.is_there(p):
                continue
            ti.atomic_max(most, self._distance(self.particles.position[p], self.place[p]))
        return most
