"""Every field of the material points."""

import numpy as np
import taichi as ti

from taichi_silo.runtime import real


@ti.data_oriented
class Particles:
    """State of `count` material points; all quantities per metre run of the silo.

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
    ==============  ==========  ========================================================================

    The void ratio is no field of its own: e = volume * grain density / mass - 1.
    In axial symmetry masses and volumes are per radian.
    """

    NAMES = ("position", "velocity", "stress", "mass", "volume", "path")

    def __init__(self, count: int, remembers: bool = False):
        self.count, self.loads = count, 0
        self.names = self.NAMES + (("intergranular",) if remembers else ())
        self.position = ti.Vector.field(2, real)
        self.velocity = ti.Vector.field(2, real)
        self.stress = ti.Vector.field(4, real)
        self.mass = ti.field(real)
        self.volume = ti.field(real)
        self.path = ti.field(real)
        if remembers:
            self.intergranular = ti.Vector.field(4, real)
        # one record a point: a point's data lie in two neighbouring cache lines
        ti.root.dense(ti.i, count).place(*(getattr(self, name) for name in self.names))

    def arrays(self) -> dict[str, np.ndarray]:
        """All fields as arrays, first axis the points."""
        return {name: getattr(self, name).to_numpy() for name in self.names}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """Set all fields from arrays of the same shapes."""
        self.loads += 1
        for name in self.names:
            getattr(self, name).from_numpy(np.ascontiguousarray(arrays[name], dtype=np.float64))
