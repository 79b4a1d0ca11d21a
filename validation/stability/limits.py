"""Failure mode 7: where the law ends: densest and loosest packing, no stress, tension, sand that lands."""

import numpy as np

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint, wave_speed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls import Coulomb, PlaneWall
from validation.stability.bodies import block, change, solver
from validation.stability.integration import after, inadmissible
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "7 limits of the law"
LAW = GudehusBauer()
UP, SIDE, TURN = (0.0, 1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
EDGES = {  # stress p [Pa], void ratio, direction of strain
    "beyond the densest packing": (5e3, 0.49, (-1.0, -1.0, -1.0, 0.0)),
    "at the densest packing, sheared": (5e3, 0.505, TURN),
    "beyond the loosest packing": (5e3, 1.35, (-1.0, -1.0, -1.0, 0.0)),
    "at the loosest packing, sheared": (1e3, 1.29, TURN),
    "at 1 Pa, compressed": (1.0, 0.6, (0.0, -1.0, 0.0, 0.0)),
    "at 1 Pa, sheared": (1.0, 0.6, TURN),
    "pulled along one axis": (1e3, 0.6, UP),
    "pulled along all axes": (1e3, 0.6, (1.0, 1.0, 1.0, 0.0)),
}
STRAIN, PARTS = 0.02, 400


def bad_states(p: float, void_ratio: float, direction, integrator: str = "law") -> int:
    """How many of 400 states on a path of 2 % of strain are not finite, pull somewhere, or are impossibly stiff."""
    point = StressPoint(LAW, (-p, -p, -p, 0.0), void_ratio)
    bad = 0
    for _ in range(PARTS):
        strain = np.array(direction) * STRAIN / PARTS
        if integrator == "law":
            point.step(strain)
        else:
            state = np.array([[*point.stress, point.void_ratio]])
            point.stress = after("euler", LAW, state, strain[None, :])[0]
            point.void_ratio = (1.0 + point.void_ratio) * float(np.exp(strain[:3].sum())) - 1.0
        finite = np.isfinite(point.stress).all() and np.isfinite(wave_speed(LAW, point.stress, point.void_ratio))
        bad += not finite or bool(inadmissible(point.stress[None, :])[0])
    return bad


def drop(shape_name: str = "ugimp", height: float = 0.05) -> dict[str, float]:
    """A block of dense sand falls on a floor in a box, and comes to rest.

    What must come out: all mass there, the floor carries its weight, no void ratio beyond the limits.

    Returns
    -------
    bad: points that are not finite or outside; void_low, void_high; floor: force over weight; time of the fall [s].

    """
    cell, size, g = 0.01, 0.1, 9.81
    shape = SHAPES[shape_name](0.5)
    density = LAW.grain_density / 1.6
    particles, grid = block(
        width=size, height=size, cell=cell, density=density, origin=(0.0, height), box=(size, 2.0 * size + height),
        extra=Particles.extras(LAW, shape, Flip()),
    )  # fmt: skip
    change(particles, stress=np.tile([-1.0, -1.0, -1.0, 0.0], (particles.count, 1)))
    walls = (
        PlaneWall("left", 0, -1, MARGIN, Coulomb()), PlaneWall("right", 0, 1, grid.node_along(size), Coulomb()),
        PlaneWall("floor", 1, -1, MARGIN, Coulomb(20.0)),
    )  # fmt: skip
    body = solver(particles, grid, shape, LAW, walls, control=NoiseControl(relaxation=50.0))
    time, low, high, force = 0.0, np.inf, -np.inf, []
    while time < 1.5:
        steps = 50
        dt = min(0.9 * body.point_sums().stable_step, 2e-5)
        body.advance(steps, dt, gravity=(g, g))
        time += steps * dt
        reaction, _ = body.impulses.read_and_reset()
        if time > 1.2:
            force.append(reaction[2, :, 1].sum() / (steps * dt))
        now = particles.arrays()
        e = now["volume"] * LAW.grain_density / now["mass"] - 1.0
        low, high = min(low, float(e.min())), max(high, float(e.max()))
        if body.point_sums().strays:
            break
    finite = np.isfinite(now["stress"]).all(axis=1) & np.isfinite(now["position"]).all(axis=1)
    weight = now["mass"].sum() * g
    return {
        "bad": float((~finite).sum() + body.point_sums().strays), "void_low": low, "void_high": high,
        "floor": float(np.mean(force)) / weight if force else 0.0,
    }  # fmt: skip


def measure(full: bool = True) -> list[Measurement]:
    """States beyond each edge of the law, with its guards and without; a block that falls and lands."""
    found = []
    for words, (p, e, direction) in EDGES.items():
        bad = {"law": bad_states(p, e, direction), "Euler's rule, unguarded": bad_states(p, e, direction, "euler")}
        found += measurements(f"bad states {words}", f"of {PARTS}", "<=", 0, bad)
    shapes = SHAPES if full else ("ugimp",)
    drops = {name: drop(name) for name in shapes}
    for measure, words, relation, bound in (
        ("bad", "points lost when sand falls and lands", "<=", 0),
        ("void_low", "least void ratio when sand lands", ">=", 0.9 * LAW.e_d0),
        ("floor", "floor's force on landed sand over its weight", ">=", 0.99),
        ("floor", "floor's force on landed sand over its weight ", "<=", 1.01),
    ):
        found += measurements(words, "-", relation, bound, {name: d[measure] for name, d in drops.items()})
    return found
