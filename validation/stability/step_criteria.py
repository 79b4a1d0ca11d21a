"""Criteria of the time step: what theory says, each from the present state of the points and nodes.

`auto`
    the shape's own fraction of the least h / (c + |v|): the rigorous bound at its worst over all places of a lattice.
    What a run uses.
`rigorous`
    2 / sqrt(max_p c^2 sum_i |grad S_ip|^2 / S_ip) at the places that the points have now (lumped mass matrix,
    Irons and Treharne's argument).
`courant`
    least h / (c + |v|): Courant, Friedrichs and Lewy's condition.
`velocity`
    least h / |v|: no point may cross a cell in a step (Jiang et al. 2016).
`inversion`
    the greatest dt with dt |grad v| + dt^2 |grad a| <= 1 at all points: no two neighbours may change places in a step,
    whatever moves them. A condition on the solution itself, not on its linear waves; derived here in place of the
    non-linear criterion of Berzins (2018), whose formula was not at hand.
"""

import math

from taichi_silo.mpm.g2p import gradient
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.point_weights import weights
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.solver import Solver


@ti.data_oriented
class Criteria:
    """Evaluates all criteria for the present state of a solver, which has done a step."""

    NAMES = ("auto", "rigorous", "courant", "velocity", "inversion")

    def __init__(self, solver: Solver):
        self.solver = solver
        self.found = ti.field(real, shape=2)

    def take(self, dt: float) -> dict[str, float]:
        """Time steps [s] by criterion; `dt` is the step that made the present velocities."""
        survey = self.solver.point_sums()
        self._take(dt)
        square, inverse = self.found.to_numpy()
        return {
            "auto": survey.stable_step,
            "rigorous": 2.0 / math.sqrt(square),
            "courant": survey.transit,
            "velocity": self.solver.grid.cell_size / max(survey.speed, 1e-300),
            "inversion": 1.0 / max(inverse, 1e-300),
        }

    @ti.kernel
    def _take(self, dt: real):
        for _ in range(1):
            self.found[0], self.found[1] = 0.0, 0.0
        for p in range(self.solver.particles.active[None]):
            square, inverse = at_point(self.solver, p, dt)
            ti.atomic_max(self.found[0], square)
            ti.atomic_max(self.found[1], inverse)


@ti.func
def at_point(s: ti.template(), p, dt):
    """c^2 sum |grad S|^2 / S and 1 / dt of the criterion `inversion`, at point p of solver s."""
    stress = s.particles.stress[p]
    e = s.particles.volume[p] * s.law.grain_density / s.particles.mass[p] - 1.0
    square = s.law.stiffness((stress[0], stress[1], stress[2], stress[3]), e) * (1.0 + e) / s.law.grain_density
    dx, dy = 1.0 / s.grid.cell_size, 1.0 / s.grid.cell_height(0)
    total = 0.0
    for patch in ti.static(range(s.shape.PATCHES)):
        _i, sx, gx, _j, sy, gy = weights(s.particles, s.grid, s.shape, p, 0, patch)
        for b in ti.static(range(s.shape.NODES)):
            for a in ti.static(range(s.shape.NODES)):
                weight = sx[a] * sy[b]
                slope = (gx[a] * sy[b] * dx) ** 2 + (sx[a] * gy[b] * dy) ** 2
                if weight > 0.0:
                    total += slope / weight
    L = gradient(s.particles, s.grid, s.shape, s.grid.velocity, s.surroundings.geometry, p, 0)
    A = gradient(s.particles, s.grid, s.shape, s.grid.change, s.surroundings.geometry, p, 0)
    v = ti.sqrt(L[0] ** 2 + L[1] ** 2 + L[2] ** 2 + L[3] ** 2)
    turn = ti.sqrt(A[0] ** 2 + A[1] ** 2 + A[2] ** 2 + A[3] ** 2) / dt
    return square * total, 0.5 * (v + ti.sqrt(v * v + 4.0 * turn))
