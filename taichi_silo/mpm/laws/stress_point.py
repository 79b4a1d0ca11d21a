"""Drive any law along a path at one point, on the very functions that the solver uses."""

import numpy as np

from taichi_silo.mpm.contracts import Law, Numbers
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws.integrate import update
from taichi_silo.mpm.laws.several import laws_of
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.tensors import norm

vec4 = ti.types.vector(4, real)
vec9 = ti.types.vector(9, real)
vec11 = ti.types.vector(11, real)

NEWTON_TOLERANCE = 1e-9  # on the stress that a free strain is to bring about, relative to the stress


@ti.kernel
def _follow(law: ti.template(), stress: vec4, h: vec4, e: real, strain: vec4, spin: real, count: ti.i32) -> vec9:
    s0, s1, s2, s3 = stress[0], stress[1], stress[2], stress[3]
    h0, h1, h2, h3 = h[0], h[1], h[2], h[3]
    void_ratio = e
    D = (strain[0], strain[1], strain[2], strain[3])
    ti.loop_config(serialize=True)
    for _ in range(1):
        for _step in range(count):
            s0, s1, s2, s3, h0, h1, h2, h3, void_ratio = update(
                law, (s0, s1, s2, s3), (h0, h1, h2, h3), void_ratio, D, spin, norm(D), 1.0
            )
    return vec9(s0, s1, s2, s3, h0, h1, h2, h3, void_ratio)


@ti.func
def _trial(law: ti.template(), s, h, e, strain, x, free: ti.template(), tied: ti.template(), spin):
    D = ti.Vector([strain[0], strain[1], strain[2], strain[3]])
    D[free], D[tied] = x, x
    tensor = (D[0], D[1], D[2], D[3])
    s0, s1, s2, s3, h0, h1, h2, h3, after = update(
        law, (s[0], s[1], s[2], s[3]), (h[0], h[1], h[2], h[3]), e, tensor, spin, norm(tensor), 1.0
    )
    return ti.Vector([s0, s1, s2, s3]), ti.Vector([h0, h1, h2, h3]), after


@ti.kernel
def _seek(
    law: ti.template(), stress: vec4, h: vec4, e: real, strain: vec4, spin: real, free: ti.template(),
    tied: ti.template(), target: real, count: ti.i32,
) -> vec11:  # fmt: skip
    """Newton's iteration on one strain in each increment; the last two results are its sum and the worst miss."""
    s, state, void_ratio = stress, h, e
    x, total, worst = strain[free], 0.0, 0.0
    ti.loop_config(serialize=True)
    for _ in range(1):
        for _step in range(count):
            size, best, found, tries = ti.abs(s).max(), 1e300, x, 0
            probe = 1e-3 * ti.abs(strain).max() + 1e-12
            while best > NEWTON_TOLERANCE * size and tries < 40:
                miss = _trial(law, s, state, void_ratio, strain, x, free, tied, spin)[0][free] - target
                if ti.abs(miss) < best:
                    best, found = ti.abs(miss), x
                beside = _trial(law, s, state, void_ratio, strain, x + probe, free, tied, spin)[0][free] - target
                x -= miss * probe / (beside - miss)
                tries += 1
            x = found
            s, state, void_ratio = _trial(law, s, state, void_ratio, strain, x, free, tied, spin)
            total += x
            # where the number of sub-steps changes with the strain, the stress jumps by the error of one
            worst = ti.max(worst, best)
    return vec11(
        s[0], s[1], s[2], s[3], state[0], state[1], state[2], state[3], void_ratio, total, worst
    )  # fmt: skip


class StressPoint:
    """One point of a material.

    Parameters
    ----------
    law : a law of `taichi_silo.laws`.
    stress : (xx, yy, zz, xy) [Pa], tension positive.
    void_ratio : e.
    h : intergranular strain (xx, yy, zz, xy); without meaning for a law that does not remember.

    """

    def __init__(self, law: Law, stress: Numbers, void_ratio: float, h: Numbers = (0.0, 0.0, 0.0, 0.0)):
        self.law = law
        self.stress = np.array(stress, dtype=float)
        self.h = np.array(h, dtype=float)
        self.void_ratio = float(void_ratio)

    def trial(self, strain: Numbers, spin: float = 0.0, count: int = 1) -> np.ndarray:
        """Stresses (4) [Pa], h (4) and void ratio after `count` equal strain increments; the point stays as it is.

        Parameters
        ----------
        strain : each increment (xx, yy, zz, xy).
        spin : rotation in each [rad].
        count : how many.

        """
        given = vec4(*map(float, strain))
        return np.array(
            _follow(self.law, vec4(*self.stress), vec4(*self.h), self.void_ratio, given, float(spin), count)
        )

    def step(self, strain: Numbers, spin: float = 0.0, count: int = 1) -> None:
        """Apply `count` strain increments (xx, yy, zz, xy) and rotations [rad]."""
        result = self.trial(strain, spin, count)
        self.stress, self.h, self.void_ratio = result[:4], result[4:8], float(result[8])

    def step_mixed(
        self, strain: Numbers, spin: float, free: int, target: float, tied: int | None = None, count: int = 1
    ) -> np.ndarray:
        """Apply `count` increments in each of which one strain follows from a stress.

        Parameters
        ----------
        strain : each increment (xx, yy, zz, xy); a first guess where free.
        spin : rotation in each [rad].
        free : component (0 to 3) whose strain is unknown.
        target : its stress after each increment [Pa].
        tied : component whose strain equals that of `free` (axial symmetry), or None.
        count : how many.

        Returns
        -------
        The sum of the strain increments.

        Raises
        ------
        RuntimeError
            if no strain brings the stress within 5e-5 of its target.

        """
        given = vec4(*map(float, strain))
        tied = free if tied is None else tied
        state = vec4(*self.stress), vec4(*self.h), self.void_ratio
        result = np.array(_seek(self.law, *state, given, float(spin), free, tied, float(target), count))
        if not result[10] < 5e-5 * np.abs(self.stress).max():
            raise RuntimeError(f"no strain gives the stress {target} Pa; the last error was {result[10]} Pa")
        self.stress, self.h, self.void_ratio = result[:4], result[4:8], float(result[8])
        total = np.array(strain, dtype=float) * count
        total[[free, tied]] = result[9]
        return total


@ti.kernel
def _stiffness(law: ti.template(), s0: real, s1: real, s2: real, s3: real, e: real) -> real:
    return law.stiffness((s0, s1, s2, s3), e)


def wave_speed(law: Law, stress: Numbers, void_ratio: float) -> float:
    """Upper bound of the speed of a plane wave [m/s] at a stress (xx, yy, zz, xy) [Pa]."""
    stiffness = max(_stiffness(one, *map(float, stress), float(void_ratio)) for one in laws_of(law))
    return float(np.sqrt(stiffness * (1.0 + void_ratio) / law.grain_density))
