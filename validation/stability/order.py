"""Failure mode 12: order of accuracy, from manufactured solutions with large strain and large rotation."""

import math

import numpy as np

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import TRANSFERS, Flip
from taichi_silo.mpm.walls import Frictionless, PlaneWall
from validation.stability.bodies import block, change, solver
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "12 order of accuracy"
DENSITY = 1000.0
LAW = Elastic(1e4, 0.0)
SPEED = math.sqrt(LAW.young_modulus_Pa / DENSITY)
COURANT = 0.1
MOST_STEPS = 100_000


def bar(shape, cells: int, amplitude: float = 0.05, transfer=None, update: str = "last") -> float:
    """RMS error of the displacement of a bar that swings with u = A sin(pi X) sin(pi c t), over A.

    Between fixed ends a unit apart; half a period. The law is logarithmic (Jaumann's rate in one dimension), so
    rho_0 u_tt = E (ln F)' + rho_0 b, F = 1 + u': b makes the motion exact for any amplitude.
    """
    transfer = transfer or Flip()
    h = 1.0 / cells
    particles, grid = block(
        width=1.0, height=2 * h, cell=h, points_per_axis=2, density=DENSITY,
        extra=Particles.extras(LAW, shape, transfer),
    )  # fmt: skip
    walls = (
        PlaneWall("left", 0, -1, MARGIN, Frictionless()), PlaneWall("right", 0, 1, cells + MARGIN, Frictionless()),
        PlaneWall("bottom", 1, -1, MARGIN, Frictionless()), PlaneWall("top", 1, 1, MARGIN + 2, Frictionless()),
    )  # fmt: skip
    body = solver(particles, grid, shape, LAW, walls, transfer=transfer, stress_update=update)
    X = particles.arrays()["position"][:, 0]
    omega, k = math.pi * SPEED, math.pi
    change(particles, velocity=np.stack([amplitude * omega * np.sin(k * X), 0.0 * X], axis=1))
    duration = 1.0 / SPEED
    steps = min(MOST_STEPS, math.ceil(duration / (COURANT * h / SPEED)))
    dt = duration / steps
    worst = 0.0
    for number in range(steps):
        t = number * dt
        wave = amplitude * math.sin(omega * t)
        u_tt, u_x, u_xx = -(omega**2) * wave * np.sin(k * X), wave * k * np.cos(k * X), -wave * k**2 * np.sin(k * X)
        b = u_tt - SPEED**2 * u_xx / (1.0 + u_x)
        v = particles.velocity.to_numpy()
        v[:, 0] += dt * b
        particles.velocity.from_numpy(v)
        body.advance(1, dt)
        exact = X + amplitude * math.sin(omega * (t + dt)) * np.sin(k * X)
        error = float(np.sqrt(((particles.position.to_numpy()[:, 0] - exact) ** 2).mean())) / amplitude
        worst = max(worst, error) if math.isfinite(error) else math.inf
    return worst


def ring(shape, cells: int, angle: float = 0.15, turns: float = 0.25) -> float:
    """RMS error of the places in a ring that turns as a whole while its middle runs ahead, over the RMS of the latter.

    Every point X = (R, theta) moves to (R, theta + alpha), alpha = A sin(pi t) g(R) + Omega t, with
    g = 1 - 32 (R-1)^2 + 256 (R-1)^4, whose slope vanishes at both edges (R = 3/4 and 5/4): no stress there. In a frame
    that turns with it a point is in simple shear gamma = R alpha_R, up to 0.9; under Jaumann's rate that gives
    sigma_rt = G sin gamma and sigma_tt = -sigma_rr = G (1 - cos gamma) exactly, and b from the equations of motion.
    Until t = 1/2, when the ring has done `turns` turns. `cells` are those over the unit of length.
    """
    h = 1.0 / cells
    G = LAW.shear_modulus
    particles, grid = block(
        width=3.0, height=3.0, cell=h, points_per_axis=2, density=DENSITY,
        extra=Particles.extras(LAW, shape, Flip()),
        keep=lambda place: np.abs(np.hypot(*(place - 1.5).T) - 1.0) < 0.25,
    )  # fmt: skip
    body = solver(particles, grid, shape, LAW)
    arm = particles.arrays()["position"] - 1.5
    R, theta = np.hypot(*arm.T), np.arctan2(arm[:, 1], arm[:, 0])
    d = R - 1.0
    g, g1, g2 = 1 - 32 * d**2 + 256 * d**4, -64 * d + 1024 * d**3, -64 + 3072 * d**2
    duration = 0.5
    steps = math.ceil(duration / (COURANT * h / SPEED))
    dt = duration / steps
    whole = 2.0 * math.pi * turns / duration
    first = (angle * math.pi * g + whole) * R
    change(particles, velocity=first[:, None] * np.stack([-np.sin(theta), np.cos(theta)], axis=1))
    for number in range(steps):
        t = number * dt
        a, a_t, a_tt = (angle * f for f in (math.sin(math.pi * t), math.pi * math.cos(math.pi * t),
                                            -(math.pi**2) * math.sin(math.pi * t)))  # fmt: skip
        gamma, gamma_r = R * a * g1, a * (g1 + R * g2)
        tau, tau_r = G * np.sin(gamma), G * np.cos(gamma) * gamma_r
        rr, rr_r = -G * (1 - np.cos(gamma)), -G * np.sin(gamma) * gamma_r
        b_r = -R * (a_t * g + whole) ** 2 - (rr_r + 2 * rr / R) / DENSITY
        b_t = R * a_tt * g - (tau_r + 2 * tau / R) / DENSITY
        turn = theta + a * g + whole * t
        c, s = np.cos(turn), np.sin(turn)
        v = particles.velocity.to_numpy()
        v[:, 0] += dt * (b_r * c - b_t * s)
        v[:, 1] += dt * (b_r * s + b_t * c)
        particles.velocity.from_numpy(v)
        body.advance(1, dt)
    turn = theta + angle * math.sin(math.pi * duration) * g + whole * duration
    exact = R[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    error = np.sqrt(((particles.position.to_numpy() - 1.5 - exact) ** 2).sum(axis=1).mean())
    return float(error / np.sqrt(((angle * g * R) ** 2).mean())) if np.isfinite(error) else math.inf


def slope(errors: dict[int, float]) -> float:
    """Order between the coarsest and the finest grid; -inf if an error is none."""
    first, last = min(errors), max(errors)
    if not (math.isfinite(errors[first]) and math.isfinite(errors[last])):
        return -math.inf
    return math.log(errors[first] / errors[last]) / math.log(last / first)


def curves(full: bool = True) -> dict[str, dict[str, dict[int, float]]]:
    """Errors by solution, method and number of cells."""
    fine, wide = ((8, 16, 32, 64), (12, 24, 48)) if full else ((8, 32), (16, 32))
    names = SHAPES if full else ("linear", "ugimp", "cpdi")
    found = {
        "small swing": {name: {n: bar(SHAPES[name](0.25), n, 1e-4) for n in fine} for name in names},
        "large swing": {name: {n: bar(SHAPES[name](0.25), n, 0.1) for n in fine} for name in names},
        "large rotation": {name: {n: ring(SHAPES[name](0.25), n) for n in wide} for name in names if full},
    }
    if full:
        ugimp = SHAPES["ugimp"](0.25)
        for word in TRANSFERS:
            if word != "flip":
                found["large swing"][f"ugimp, {word}"] = {n: bar(ugimp, n, 0.1, TRANSFERS[word]()) for n in fine}
        for word in ("first", "modified"):
            found["large swing"][f"ugimp, stress {word}"] = {n: bar(ugimp, n, 0.1, None, word) for n in fine}
    return found


def judge(found: dict) -> list[Measurement]:
    """Slopes, and the errors on the finest grid."""
    rows = []
    for solution, methods in found.items():
        if methods:
            slopes = {name: slope(errors) for name, errors in methods.items()}
            last = {name: errors[max(errors)] for name, errors in methods.items()}
            finest = max(next(iter(methods.values())))
            rows += measurements(f"order of accuracy, {solution}", "-", ">=", 0.8, slopes)
            rows += measurements(f"error with {finest} cells, {solution}", "of the motion", "<=", 0.02, last)
    return rows
