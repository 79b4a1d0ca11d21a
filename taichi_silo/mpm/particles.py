"""Every field of the material points."""

import numpy as np
import taichi as ti

from taichi_silo.mpm.runtime import LANES, real, real_place, wide


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
        self.count, self.revision = count, 0
        self.names = self.NAMES + extra
        for name in self.names:
            width, kind = self.WIDTHS.get(name), real_place if name == "position" else real
            setattr(self, name, ti.Vector.field(width, kind) if width else ti.field(kind))
        self.fields = {name: getattr(self, name) for name in self.names}
        # one record a point: a point's data lie in two neighbouring cache lines
        ti.root.dense(ti.i, count).place(*(getattr(self, name) for name in self.names))
        self.active = ti.field(ti.i32, shape=())
        self.active[None] = count
        self.groups = (count + LANES - 1) // LANES
        # which point stands in which lane of which group (lanes.py); `count` where there is none
        self.order = ti.field(ti.i32, shape=self.groups * LANES)
        # where each field begins in the record of a group of lanes (see lanes.py)
        widths = [self.WIDTHS.get(name, 1) for name in self.names]
        self.record = sum(widths)
        self.begins = {name: sum(widths[:k]) for k, name in enumerate(self.names)}

    @staticmethod
    def extras(law, shape, transfer) -> tuple[str, ...]:
        """Names of the fields that a law, a shape and a transfer ask for."""
        wanted = (law.REMEMBERS, "intergranular"), (shape.DOMAIN, "domain"), (transfer.GRADIENT != "none", "affine")
        return tuple(name for asked, name in wanted if asked)

    @ti.func
    def read(self, lanes: ti.template(), name: ti.template(), p):
        """A field of point p, or in a kernel over lanes of group p: a value, or a tuple of its components."""
        width = ti.static(self.WIDTHS.get(name, 1))
        if ti.static(wide()):
            k = p * self.record + ti.static(self.begins[name])
            if ti.static(width == 1):
                return lanes[k]
            if ti.static(width == 2):
                return lanes[k], lanes[k + 1]
            return lanes[k], lanes[k + 1], lanes[k + 2], lanes[k + 3]
        value = ti.static(self.fields[name])[p]
        if ti.static(width == 1):
            return value
        if ti.static(width == 2):
            return value[0], value[1]
        return value[0], value[1], value[2], value[3]

    @ti.func
    def write(self, lanes: ti.template(), name: ti.template(), p, value):
        """Set a field of point or group p to a value, or a tuple."""
        width = ti.static(self.WIDTHS.get(name, 1))
        if ti.static(wide()):
            k = p * self.record + ti.static(self.begins[name])
            if ti.static(width == 1):
                lanes[k] = value
            else:
                for c in ti.static(range(width)):
                    lanes[k + c] = value[c]
        elif ti.static(width == 1):
            ti.static(self.fields[name])[p] = value
        else:
            for c in ti.static(range(width)):
                ti.static(self.fields[name])[p][c] = value[c]

    def arrays(self) -> dict[str, np.ndarray]:
        """All fields as arrays, first axis the active points."""
        return {name: getattr(self, name).to_numpy()[: self.active[None]] for name in self.names}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """Set all fields from arrays of the same shapes, of at most `count` points; `affine` may be left out (0)."""
        self.revision += 1
        number = len(arrays["mass"])
        for name in self.names:
            field = getattr(self, name)
            full = np.zeros((self.count, self.WIDTHS[name]) if name in self.WIDTHS else self.count)
            if name in arrays or name != "affine":
                full[:number] = arrays[name]
            field.from_numpy(full)
        self.active[None] = number
