"""Friction that changes along a wall on a grid line: a liner, a worn course of sheet."""

import numpy as np

from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.walls.contact import Coulomb, NoSlip

SLIDES, STICKS = Coulomb(45.0), NoSlip()  # the first takes its friction as it comes


@ti.data_oriented
class Bands:
    """A friction coefficient for each slot of a wall, which may change between launches.

    ==============  ==========  =======================================================
    field           shape       meaning
    ==============  ==========  =======================================================
    mu              slot        friction coefficient; below 0: very rough, no slip
    ==============  ==========  =======================================================
    """

    def __init__(self, slots: int):
        self.mu = ti.field(real, shape=slots)

    def set(self, coefficients: np.ndarray) -> None:
        """From now on the slots have these coefficients (slots,)."""
        put(self.mu, coefficients)

    @ti.func
    def touch(self, relative, normal, slot):
        """Admissible relative velocity at a slot (see `contact`)."""
        x, y = STICKS.touch(relative, normal)
        mu = self.mu[slot]
        if mu >= 0.0:
            along = relative[0] * normal[0] + relative[1] * normal[1]
            x, y = SLIDES.slow(relative, normal, along, mu * ti.max(along, 0.0))
        return x, y
