"""Every field of the material points."""

import numpy as np
import taichi as ti

from taichi_silo.runtime import real, real_place


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
    domain          4           edges r1, r2 (x, y each) of the point's domain [m]; only for a shape that convects it
    affine          4           velocity gradient (xx, xy, yx, yy) given to the nodes [1/s]; only for some transfers
    ==============  ==========  ========================================================================

    `active` is the number of points that have not left. The void ratio is no field of its own: e = volume * grain
    density / mass - 1. In axial symmetry masses and volumes are per radian.
    """

    NAMES = ("position", "velocity", "stress", "mass", "volume", "path")
    WIDTHS = {"position": 2, "velocity": 2, "stress": 4, "intergranular": 4, "domain": 4, "affine": 4}

    def __init__(self, count: int, extra: tuple[str, ...] = ()):
        self.count, self.loads = count, 0
        self.names = self.NAMES + extra
        for name in self.names:
            width, kind = self.WIDTHS.get(name), real_place if name == "position" else real
            setattr(self, name, ti.Vector.field(width, kind) if width else ti.field(kind))
        # one record a point: a point's data lie in two neighbouring cache lines
        ti.root.dense(ti.i, count).place(*(getattr(self, name) for name in self.names))
        self.active = ti.field(ti.i32, shape=())
        self.active[None] = count

    @staticmethod
    def extras(law, shape, transfer) -> tuple[str, ...]:
        """Names of the fields that a law, a shape and a transfer ask for."""
        wanted = (law.REMEMBERS, "intergranular"), (shape.DOMAIN, "domain"), (transfer.GRADIENT != "none", "affine")
        return tuple(name for asked, name in wanted if asked)

    def arrays(self) -> dict[str, np.ndarray]:
        """All fields as arrays, first axis the active points."""
        return {name: getattr(self, name).to_numpy()[: self.active[None]] for name in self.names}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """Set all fields from arrays of the same shapes, of at most `count` points; `affine` may be left out (0)."""
        self.loads += 1
        number = len(arrays["mass"])
        for name in self.names:
            field = getattr(self, name)
            full = np.zeros((self.count, self.WIDTHS[name]) if name in self.WIDTHS else self.count)
            if name in arrays or name != "affine":
                full[:number] = arrays[name]
            field.from_numpy(full)
        self.active[None] = number
