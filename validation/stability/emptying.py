"""A silo that empties by gravity: through an outlet until the flow stops, or through its whole bottom."""

import math

import numpy as np

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import wave_speed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.solver import Solver
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls import Coulomb, OpenFloor, PlaneWall
from taichi_silo.scene.outlets import Opening
from taichi_silo.simulation.discharge import Discharge
from validation.stability.bodies import block, change

G = 9.81
BELOW = 4  # cells under the floor, where the sand falls before it is taken out
STEP_S = 2e-3  # time between two looks at the exit


def empty(
    outlet_m: float | None, shape_name: str = "ugimp", void_ratio: float = 0.6, width: float = 0.2, height: float = 0.3,
    cell: float = 0.01, longest: float = 3.0, wall_friction_deg: float = 19.0, per_axis: int = 1,
) -> dict[str, float]:  # fmt: skip
    """Fill a silo, open it, and let the sand flow out under its weight.

    Parameters
    ----------
    outlet_m : width of the outlet in the middle of the floor; None for a floor that is taken away.
    shape_name, per_axis : shape functions, points along the edge of a cell.
    void_ratio, width, height, cell : sand and silo [m].
    longest : of the flow [s].
    wall_friction_deg : of the walls; the floor has the same.

    Returns
    -------
    mass_error : (there + gone) over the first mass, less 1; left : share of the mass that stays; bad : points that are
    not finite or left the grid elsewhere; void_low, void_high; last : time of the last outflow [s]; rate : mean
    discharge while between 10 and 50 % have left [kg/(m s)].

    """
    law, shape = GudehusBauer(), SHAPES[shape_name](0.5 / per_axis)
    base = BELOW * cell
    density = law.grain_density / (1.0 + void_ratio)
    particles, grid = block(
        width=width, height=height, cell=cell, points_per_axis=per_axis, density=density, origin=(0.0, base),
        box=(width, height + base + 2 * cell), extra=Particles.extras(law, shape, Flip()),
    )  # fmt: skip
    change(particles, stress=np.tile([-law.rest_stress] * 3 + [0.0], (particles.count, 1)))
    middle = 0.5 * density * G * height
    period = 4.0 * height / wave_speed(law, (-0.5 * middle, -middle, -0.5 * middle, 0.0), void_ratio)
    control = NoiseControl.for_column(period)
    floor_node = MARGIN + BELOW
    sides = (
        PlaneWall("left", 0, -1, MARGIN, Coulomb(wall_friction_deg)),
        PlaneWall("right", 0, 1, grid.node_along(width), Coulomb(wall_friction_deg)),
    )
    floor = PlaneWall("floor", 1, -1, floor_node, Coulomb(wall_friction_deg))
    closed = Solver(particles, grid, shape, law, (*sides, floor), control)
    drive(closed, 12.0 * period, gravity=(0.0, G))
    drive(closed, 5.0 * period, gravity=(G, G))
    # the drag towards the recent mean would brake what now accelerates: of the control only the relaxation stays
    centre = MARGIN + round(0.5 * width / cell)
    half = round(0.5 * (outlet_m or 0.0) / cell)
    opened = () if outlet_m is None else (OpenFloor(floor_node, centre - half, centre + half, floor.contact),)
    body = Solver(particles, grid, shape, law, (*sides, *opened), NoiseControl(relaxation=control.relaxation))
    # height 0 of this grid is the bottom of the box, into which the sand falls
    gone = Discharge(particles, exit_m=cell, openings=(Opening("floor", 0.0, width),), spacing_m=cell / per_axis)
    first = float(particles.arrays()["mass"].sum())
    low, high, time, last, marks, bad = math.inf, -math.inf, 0.0, 0.0, {}, 0
    while time < longest and particles.active[None] and time - last < 0.5:
        drive(body, STEP_S, gravity=(G, G))
        time += STEP_S
        if gone.take_out() is not None:
            last = time
        for part in (0.1, 0.5):
            if gone.mass > part * first:
                marks.setdefault(part, time)
        if not particles.active[None]:
            break
        now = particles.arrays()
        bad = body.point_sums().strays
        if bad:
            break
        e = now["volume"] * law.grain_density / now["mass"] - 1.0
        low, high = min(low, float(e.min())), max(high, float(e.max()))
    there = float(particles.arrays()["mass"].sum())
    rate = 0.4 * first / (marks[0.5] - marks[0.1]) if len(marks) == 2 and marks[0.5] > marks[0.1] else 0.0
    return {
        "mass_error": abs((there + gone.mass) / first - 1.0), "left": there / first, "bad": float(bad),
        "void_low": low, "void_high": high, "last": last, "rate": rate,
    }  # fmt: skip


def drive(solver: Solver, duration: float, gravity) -> None:
    """Steps of at most 0.9 of the stable length, found anew every 2 ms."""
    parts = max(1, math.ceil(duration / STEP_S))
    for number in range(parts):
        low, high = (gravity[0] + (gravity[1] - gravity[0]) * (number + k) / parts for k in (0, 1))
        growth = (low / high) ** 0.25 if low > 0.0 else 0.2
        steps = math.ceil(duration / parts / (0.9 * growth * solver.point_sums().stable_step))
        solver.advance(steps, duration / parts / steps, (low, high))
