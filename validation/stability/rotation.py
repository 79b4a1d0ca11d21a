"""Failure mode 3: large shear and rotation."""

import math

import numpy as np

from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES, ConvectedDomain
from taichi_silo.mpm.velocity_transfer import Flip
from validation.stability.bodies import block, change, solver
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "3 shear and rotation"
CELL, SIZE = 0.05, 2.0
FREE = Elastic(0.0, 0.0)  # stresses turn, nothing else
HEAVY = 1e9  # [kg/m3]: no stress moves it


def vortex(radius):
    """Angular velocity of a vortex that leaves the edges at rest [1/s]: cos^2 of the radius."""
    return np.where(radius < 0.9, np.cos(0.5 * math.pi * radius / 0.9) ** 2, 0.0)


def shear_rate(radius):
    """Rate of shear of the vortex, r d omega / dr [1/s]."""
    slope = -0.5 * math.pi / 0.9 * np.sin(math.pi * radius / 0.9)
    return np.where(radius < 0.9, radius * slope, 0.0)


def carried_round(
    shape, spin, angle: float, steps: int, stress=(0.0, 0.0, 0.0, 0.0), per_axis: int = 2, filtering=None,
):  # fmt: skip
    """Points that are led on circles with angular velocity `spin(radius)`, until those at the centre did `angle`.

    Velocities and places are exact in each step; the grid only measures what they strain. `stress` at the start is one
    for all, or a function of the places from the centre.

    Returns
    -------
    particles, radius of each point.

    """
    particles, grid = block(
        width=SIZE, height=SIZE, cell=CELL, points_per_axis=per_axis, density=HEAVY, origin=(0.5, 0.5),
        box=(SIZE + 1.0, SIZE + 1.0),
        extra=Particles.extras(FREE, shape, Flip()),
        keep=lambda place: np.hypot(*(place - 0.5 * SIZE).T) < 0.5 * SIZE,
    )  # fmt: skip
    middle = 0.5 + 0.5 * SIZE
    arm = particles.arrays()["position"] - middle
    radius = np.hypot(*arm.T)
    given = stress(arm) if callable(stress) else np.tile(stress, (len(arm), 1))
    change(particles, stress=given)
    body = solver(particles, grid, shape, FREE, filtering=filtering)
    rate = spin(radius)
    dt = angle / steps / float(spin(np.array(0.0)))
    for number in range(steps):
        turn = rate * dt * number
        c, s = np.cos(turn), np.sin(turn)
        x, y = c * arm[:, 0] - s * arm[:, 1], s * arm[:, 0] + c * arm[:, 1]
        particles.position.from_numpy(np.stack([x, y], axis=1) + middle)
        particles.velocity.from_numpy(np.stack([-rate * y, rate * x], axis=1))
        body.advance(1, dt)
    return particles, radius


def vortex_error(shape, turns: float = 2.0, steps: int = 400) -> tuple[float, float]:
    """Error of the path length of the strain in the vortex (RMS), and spread of the volumes, both over the RMS path.

    Exactly, ||D|| = |r omega'| / sqrt 2 at every point, for ever, and no volume changes.
    """
    particles, radius = carried_round(shape, vortex, 2.0 * math.pi * turns, steps)
    found = particles.arrays()
    exact = np.abs(shear_rate(radius)) / math.sqrt(2.0) * 2.0 * math.pi * turns
    inner = radius < 0.8
    size = np.sqrt((exact[inner] ** 2).mean())
    error = np.sqrt(((found["path"] - exact)[inner] ** 2).mean())
    return float(error / size), float(np.ptp(found["volume"][inner]) / (0.5 * CELL) ** 2 / size)


def rotation_error(shape, steps: int = 500) -> float:
    """Error of the stress of a body that has turned by 90 deg, over its first deviator: a turned stress is expected."""
    start = (-2e3, -1e3, -1e3, 300.0)
    particles, radius = carried_round(shape, lambda r: 1.0 + 0.0 * r, 0.5 * math.pi, steps, start)
    exact = np.array([start[1], start[0], start[2], -start[3]])
    inner = radius < 0.8
    error = np.abs(particles.arrays()["stress"][inner] - exact).max()
    return float(error / math.hypot(0.5 * (start[0] - start[1]), start[3]))


def rotation_error_without_objective_rate() -> float:
    """Error of a stress that stays as it is while the body turns, over its deviator: without an objective rate."""
    start = (-2e3, -1e3, -1e3, 300.0)
    change_of = max(abs(start[0] - start[1]), 2.0 * abs(start[3]))
    return change_of / math.hypot(0.5 * (start[0] - start[1]), start[3])


def domain_at_a_right_angle(shape, steps: int = 500) -> float:
    """Least area of a domain as the shape uses it, over the point's volume, in a body that turned by 90 deg."""
    particles, radius = carried_round(shape, lambda r: 1.0 + 0.0 * r, 0.5 * math.pi, steps)
    a, b, c, d = particles.arrays()["domain"][radius < 0.8].T
    area = np.abs(a * d - b * c) if shape.PATCHES > 1 else np.abs(a * d)
    return float((area / (0.5 * CELL) ** 2).min())


def measure(full: bool = True) -> list[Measurement]:
    """A vortex for every shape, a rigid rotation for every shape, and the domains that are left."""
    shapes = dict(SHAPES.items()) | {"cpdi unguarded": lambda half: ConvectedDomain(half, guarded=False)}
    found = []
    for turns in (2.0, 8.0) if full else (2.0,):
        errors = {name: vortex_error(kind(0.25), turns, int(200 * turns)) for name, kind in shapes.items()}
        words = f"error of the strain path in a vortex, {turns:g} turns"
        found += measurements(words, "of the path", "<=", 0.05, {name: e[0] for name, e in errors.items()})
        words = f"spread of the volumes in a vortex, {turns:g} turns"
        found += measurements(words, "of the path", "<=", 0.1, {name: e[1] for name, e in errors.items()})
    names = SHAPES if full else ("ugimp", "cpdi")
    errors = {name: rotation_error(SHAPES[name](0.25)) for name in names}
    errors["ugimp, no objective rate"] = rotation_error_without_objective_rate()
    found += measurements("error of a stress that turned by 90 deg", "of its deviator", "<=", 0.02, errors)
    areas = {name: domain_at_a_right_angle(SHAPES[name](0.25)) for name in ("cpgimp", "cpdi")}
    return found + measurements("area of a domain that turned by 90 deg", "of its own", ">=", 0.9, areas)
