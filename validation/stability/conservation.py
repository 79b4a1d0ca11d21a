"""Failure mode 11: what each transfer, stress update and shape keeps of momentum and energy over a long run."""

import math

import numpy as np

from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import TRANSFERS
from validation.stability.bodies import block, change, solver
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "11 conservation"
CELL, CELLS, DENSITY = 0.01, 6, 1500.0
LAW = Elastic(1e6, 0.0)
SPEED = math.sqrt(LAW.young_modulus_Pa / DENSITY)


class FreeBlock:
    """An elastic block that drifts, spins and swings, without walls."""

    def __init__(self, transfer: str = "flip", update: str = "last", shape: str = "ugimp"):
        size = CELLS * CELL
        kind, carrier = SHAPES[shape](0.25), TRANSFERS[transfer]()
        self.particles, grid = block(
            width=size, height=size, cell=CELL, points_per_axis=2, density=DENSITY, origin=(4 * CELL, 4 * CELL),
            box=(size + 8 * CELL, size + 8 * CELL), extra=Particles.extras(LAW, kind, carrier),
        )  # fmt: skip
        self.body = solver(self.particles, grid, kind, LAW, transfer=carrier, stress_update=update)
        self.dt = 0.2 * CELL / SPEED

    def push(self, spin: float = 0.0, drift=(0.0, 0.0), swing: float = 0.0) -> None:
        """Rigid rotation [rad/s], translation [m/s] and a breathing mode of some amplitude [m/s]."""
        place = self.particles.arrays()["position"]
        arm = place - place.mean(axis=0)
        half = 0.5 * CELLS * CELL
        v = spin * np.stack([-arm[:, 1], arm[:, 0]], axis=1) + np.array(drift)
        v[:, 0] += swing * np.sin(0.5 * math.pi * arm[:, 0] / half)
        change(self.particles, velocity=v)

    def momentum(self) -> np.ndarray:
        """Linear (x, y), and angular about the origin."""
        now = self.particles.arrays()
        m, v, x = now["mass"], now["velocity"], now["position"]
        turning = m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
        if "affine" in now:  # what the affine fields add: m (D_xx C_yx - D_yy C_xy)
            D, C = self._second_moments(x), now["affine"]
            turning += m @ (D[:, 0] * C[:, 2] - D[:, 1] * C[:, 1])
        return np.array([*(m @ v), turning])

    def _second_moments(self, place) -> np.ndarray:
        """Sum of S (x_i - x_p)^2 along both axes [m2] for hats averaged over a point's domain.

        Around any place y hats have the second moment f (1 - f) h^2, f being the place in its cell; to its mean over
        the domain comes that of (y - x_p)^2.
        """
        offset = (np.arange(200) + 0.5) / 200 * 0.5 - 0.25
        y = place[:, :, None] / CELL + offset
        f = y - np.floor(y)
        return CELL**2 * ((f * (1.0 - f)).mean(axis=2) + (offset**2).mean())

    def energy(self) -> float:
        """Kinetic and elastic [J/m]."""
        now = self.particles.arrays()
        kinetic = 0.5 * now["mass"] @ (now["velocity"] ** 2).sum(axis=1)
        s = now["stress"]
        density = 0.5 * ((s[:, :3] ** 2).sum(axis=1) + 2.0 * s[:, 3] ** 2) / LAW.young_modulus_Pa
        return float(kinetic + now["volume"] @ density)


def drifts(transfer="flip", update="last", shape="ugimp", steps: int = 100_000) -> dict[str, float]:
    """Changes over many steps: linear momentum, angular momentum of a spinning block, energy of a swinging one."""
    case = FreeBlock(transfer, update, shape)
    case.push(spin=2.0, drift=(1e-6, 2e-6), swing=0.0)
    first = case.momentum()
    # three quarters of a turn
    turn = min(steps, int(0.75 * 2.0 * math.pi / 2.0 / case.dt))
    case.body.advance(turn, case.dt)
    last = case.momentum()
    size = case.particles.arrays()["mass"].sum() * 1e-6
    still = FreeBlock(transfer, update, shape)
    still.push(swing=1e-3)
    start = still.energy()
    still.body.advance(steps, still.dt)
    return {
        "linear": float(np.abs(last[:2] - first[:2]).max() / size),
        "angular": float(abs(last[2] / first[2] - 1.0)),
        "energy": abs(float(still.energy() / start) - 1.0),
    }


def measure(full: bool = True) -> list[Measurement]:
    """Each transfer with uGIMP; the stress updates; each shape with FLIP."""
    steps = 100_000 if full else 5_000
    cases = {name: {"transfer": name} for name in TRANSFERS}
    if full:
        cases |= {"flip, stress first": {"update": "first"}, "flip, modified last": {"update": "modified"}}
        cases |= {f"flip, {name}": {"shape": name} for name in SHAPES if name != "ugimp"}
    found = {name: drifts(steps=steps, **options) for name, options in cases.items()}
    pick = lambda measure: {name: values[measure] for name, values in found.items()}  # noqa: E731
    return [
        *measurements("change of linear momentum", "of its size", "<=", 1e-6, pick("linear")),
        *measurements("change of angular momentum, 3/4 of a turn", "of its size", "<=", 0.01, pick("angular")),
        *measurements(f"change of the energy of a swing, {steps:,} steps", "of its start", "<=", 0.1, pick("energy")),
    ]
