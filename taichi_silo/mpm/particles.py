"""Every field of the material points."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from taichi_silo.mpm.contracts import Law, Shape, Transfer
from taichi_silo.mpm.field_memory import present, put, values
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.several import are_several
from taichi_silo.mpm.runtime import is_cpu, real, real_place, whole_numbers


@ti.data_oriented
class Particles:
    """State of up to `count` material points; all quantities per metre run of the silo.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    position        2           place in the frame of the grid, whose origin follows the bottom plate [m]
    velocity        2           velocity in the frame of the laboratory [m/s]
    stress          4           Cauchy stress (xx, yy, zz, xy), tension positive [Pa]
    mass            scalar      [kg/m]
    volume          scalar      present volume, grains and voids [m2]
    path            scalar      path length of the strain, integral of ||D|| dt [-]
    intergranular   4           intergranular strain h (xx, yy, zz, xy); only for a law that remembers
    sand            scalar      number of the point's law among `laws.several.Several`; only where there are several
    domain          4           edges r1, r2 (x, y each) of the point's domain [m]; only for a shape that convects it
    affine          4           velocity gradient (xx, xy, yx, yy) given to the nodes [1/s]; only for some transfers
    ==============  ==========  ========================================================================

    `active` is the number of points that have not left, for kernels; `number` is the same in Python. The void ratio is
    no field of its own: e = volume * grain density / mass - 1. In axial symmetry masses and volumes are per radian.
    """

    NAMES = ("position", "velocity", "stress", "mass", "volume", "path")
    WIDTHS = {"position": 2, "velocity": 2, "stress": 4, "intergranular": 4, "domain": 4, "affine": 4}

    def __init__(self, count: int, extra: tuple[str, ...] = ()):
        self.count, self.revision = count, 0
        self.names = self.NAMES + extra
        for name in self.names:
            width, kind = self.WIDTHS.get(name), real_place if name == "position" else real
            setattr(self, name, ti.Vector.field(width, kind) if width else ti.field(kind))
        self.fields = {name: getattr(self, name) for name in self.names}
        if is_cpu():  # one record a point: a point's data lie in two neighbouring cache lines
            ti.root.dense(ti.i, count).place(*self.fields.values())
        else:  # threads beside each other read what lies side by side
            for field in self.fields.values():
                ti.root.dense(ti.i, count).place(field)
        (self.active,) = whole_numbers(())
        self._count_active(count)

    @classmethod
    def lattice(
        cls, law: Law, width_m: float, height_m: float, spacing_m: float, *, origin_m: Sequence[float] = (0.0, 0.0),
        turned_deg: float = 0.0, void_ratio: float = 0.0, extra: tuple[str, ...] = (),
    ) -> "Particles":  # fmt: skip
        """A rectangle of points at rest under the law's rest stress, row after row from below.

        Parameters
        ----------
        law : gives grain density and rest stress.
        width_m, height_m, spacing_m : size of the rectangle, distance of its points.
        origin_m : its lower left corner.
        turned_deg : by which it is turned around that corner, to the left.
        void_ratio : e, so that the density is that of the grains over 1 + e.
        extra : names of further fields (see `extras`).

        """
        d = spacing_m
        x, y = np.meshgrid((np.arange(round(width_m / d)) + 0.5) * d, (np.arange(round(height_m / d)) + 0.5) * d)
        cos, sin = math.cos(math.radians(turned_deg)), math.sin(math.radians(turned_deg))
        place = np.stack([x.ravel(), y.ravel()], axis=1) @ np.array([[cos, sin], [-sin, cos]]) + np.array(origin_m)
        count = len(place)
        particles = cls(count, extra)
        particles.load(
            {
                "position": place,
                "velocity": np.zeros((count, 2)),
                "stress": np.tile([-law.rest_stress] * 3 + [0.0], (count, 1)),
                "mass": np.full(count, law.grain_density / (1.0 + void_ratio) * d * d),
                "volume": np.full(count, d * d),
                "path": np.zeros(count),
                "intergranular": np.zeros((count, 4)),
                "domain": np.tile([d * cos, d * sin, -d * sin, d * cos], (count, 1)),
            }
        )
        return particles

    @staticmethod
    def extras(law: Law, shape: Shape, transfer: Transfer) -> tuple[str, ...]:
        """Names of the fields that a law, a shape and a transfer ask for."""
        wanted = {
            "sand": are_several(law), "intergranular": law.REMEMBERS, "domain": shape.DOMAIN,
            "affine": transfer.GRADIENT != "none",
        }  # fmt: skip
        return tuple(name for name, asked in wanted.items() if asked)

    @ti.func
    def read(self, name: ti.template(), p):
        """A field of point p: a value, or a tuple of its components."""
        width = ti.static(self.WIDTHS.get(name, 1))
        value = ti.static(self.fields[name])[p]
        if ti.static(width == 1):
            return value
        if ti.static(width == 2):
            return value[0], value[1]
        return value[0], value[1], value[2], value[3]

    @ti.func
    def write(self, name: ti.template(), p, value):
        """Set a field of point p to a value, or a tuple."""
        width = ti.static(self.WIDTHS.get(name, 1))
        if ti.static(width == 1):
            ti.static(self.fields[name])[p] = value
        else:
            for c in ti.static(range(width)):
                ti.static(self.fields[name])[p][c] = value[c]

    @ti.func
    def places(self):
        """How many places a loop over the points looks at, those of which `is_there` is true.

        On a GPU that is `count`: a loop whose length is not known when it is compiled launches far too many threads.
        """
        number = self.count
        if ti.static(is_cpu()):
            number = self.active[None]
        return number

    @ti.func
    def is_there(self, p):
        """Whether there is a point at place p."""
        there = True
        if ti.static(not is_cpu()):
            there = p < self.active[None]
        return there

    def arrays(self) -> dict[str, np.ndarray]:
        """All fields as arrays, first axis the active points."""
        return {name: self.array(name) for name in self.names}

    def array(self, name: str, first: int = 0, end: int | None = None) -> np.ndarray:
        """A field as an array, first axis the active points, or those of numbers `first` to `end`."""
        return values(self.fields[name], self.number if end is None else min(end, self.number), first)

    def present(self, name: str) -> np.ndarray:
        """As `array`, but the field itself if possible (see `field_memory.present`)."""
        return present(self.fields[name], self.number)

    def load(self, arrays: Mapping[str, np.ndarray], revision: int | None = None) -> None:
        """Set all fields from arrays of the same shapes, of at most `count` points; `affine` may be left out (0).

        The state gets the next number of revision, or the one that it had when it was saved.
        """
        self.revision = self.revision + 1 if revision is None else revision
        self._count_active(len(arrays["mass"]))
        for name, field in self.fields.items():
            put(field, arrays[name] if name in arrays or name != "affine" else 0.0, self.number)

    def keep(self, stayed: np.ndarray) -> None:
        """Go on with those of the points (n,) that have stayed, as another state."""
        number, self.revision = int(stayed.sum()), self.revision + 1
        for field in self.fields.values():
            put(field, present(field, self.number)[stayed], number)
        self._count_active(number)

    def _count_active(self, number: int) -> None:
        self.number = number
        put(self.active, number)
