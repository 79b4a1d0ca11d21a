"""Drive any law along a path at one point, on the very functions that the solver uses."""

import numpy as np
import taichi as ti

from taichi_silo.laws.integrate import march, substeps, update
from taichi_silo.runtime import real
from taichi_silo.tensors import norm

vec5 = ti.types.vector(5, real)


@ti.kernel
def _trial(
    law: ti.template(), s0: real, s1: real, s2: real, s3: real, e: real,
    xx: real, yy: real, zz: real, xy: real, spin: real,
) -> vec5:  # fmt: skip
    D = (xx, yy, zz, xy)
    a, b, c, d, void_ratio = update(law, (s0, s1, s2, s3), e, D, spin, norm(D), 1.0)
    return vec5(a, b, c, d, void_ratio)


@ti.kernel
def _substeps(
    law: ti.template(), s0: real, s1: real, s2: real, s3: real, e: real,
    xx: real, yy: real, zz: real, xy: real, spin: real,
) -> ti.i32:  # fmt: skip
    D = (xx, yy, zz, xy)
    return substeps(law, (s0, s1, s2, s3), e, D, spin, norm(D), 1.0)[0]


@ti.kernel
def _march(
    law: ti.template(), s0: real, s1: real, s2: real, s3: real, e: real,
    xx: real, yy: real, zz: real, xy: real, spin: real, count: ti.i32,
) -> vec5:  # fmt: skip
    D = (xx, yy, zz, xy)
    a, b, c, d, void_ratio = march(law, (s0, s1, s2, s3), e, D, spin, norm(D), 1.0, count)
    return vec5(a, b, c, d, void_ratio)


class StressPoint:
    """One point of a material.

    Parameters
    ----------
    law : a law of `taichi_silo.laws`.
    stress : (xx, yy, zz, xy) [Pa], tension positive.
    void_ratio : e.

    """

    def __init__(self, law, stress, void_ratio: float):
        self.law = law
        self.stress = np.array(stress, dtype=float)
        self.void_ratio = float(void_ratio)

    def trial(self, strain, spin: float = 0.0, count: int | None = None) -> np.ndarray:
        """Stresses (4) [Pa] and void ratio after a strain increment (xx, yy, zz, xy), leaving the point as it is.

        `count` fixes the number of sub-steps; without it the law's own control decides.
        """
        arguments = (self.law, *self.stress, self.void_ratio, *map(float, strain), float(spin))
        return np.array(_trial(*arguments) if count is None else _march(*arguments, count))

    def step(self, strain, spin: float = 0.0, count: int | None = None) -> None:
        """Apply a strain increment (xx, yy, zz, xy) and a rotation [rad]."""
        result = self.trial(strain, spin, count)
        self.stress, self.void_ratio = result[:4], float(result[4])

    def step_mixed(self, strain, spin: float, free, targets, tied=None, tolerance: float = 1e-8) -> None:
        """Apply an increment in which some strains follow from stresses.

        Parameters
        ----------
        strain : (xx, yy, zz, xy), the prescribed ones; a first guess where free.
        spin : rotation [rad].
        free : components (0 to 3) whose strain is unknown.
        targets : their stresses after the increment [Pa].
        tied : component whose strain equals that of free[0] (axial symmetry), or None.
        tolerance : on the stresses, relative to the stress's size.

        Raises
        ------
        RuntimeError
            if Newton's iteration does not reach the stresses.

        """
        strain = np.array(strain, dtype=float)
        free, targets = list(free), np.asarray(targets, dtype=float)
        size = np.abs(self.stress).max()
        probe = max(1e-3 * np.abs(strain).max(), 1e-10)
        # a number of sub-steps that changed with the strain would make the stresses jump under the iteration
        count = max(1, _substeps(self.law, *self.stress, self.void_ratio, *strain, float(spin)))

        def mismatch(unknown):
            trial = strain.copy()
            trial[free] = unknown
            if tied is not None:
                trial[tied] = unknown[0]
            return self.trial(trial, spin, count)[free] - targets, trial

        unknown = strain[free]
        for _ in range(60):
            error, trial = mismatch(unknown)
            if np.abs(error).max() < tolerance * size:
                break
            slope = np.empty((len(free), len(free)))
            for column in range(len(free)):
                shifted = unknown.copy()
                shifted[column] += probe
                slope[:, column] = (mismatch(shifted)[0] - error) / probe
            unknown = unknown - np.linalg.solve(slope, error)
        else:
            raise RuntimeError(f"no strain gives the stresses {targets} Pa; the last error was {error} Pa")
        self.step(trial, spin, count)


@ti.kernel
def _stiffness(law: ti.template(), s0: real, s1: real, s2: real, s3: real, e: real) -> real:
    return law.stiffness((s0, s1, s2, s3), e)


def wave_speed(law, stress, void_ratio: float) -> float:
    """Upper bound of the speed of a plane wave [m/s] at a stress (xx, yy, zz, xy) [Pa]."""
    stiffness = _stiffness(law, *map(float, stress), float(void_ratio))
    return float(np.sqrt(stiffness * (1.0 + void_ratio) / law.grain_density))
