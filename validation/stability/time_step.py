"""Failure mode 5: time steps that are too long, and those that are wrong before anything explodes."""

import math

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.scene.scene import Flow, Mesh, Method, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation
from validation.stability.bodies import block, solver
from validation.stability.measurement import Measurement, measurements
from validation.stability.step_criteria import Criteria

FAILURE_MODE = "5 time step"
CELL, CELLS, DENSITY, NOISE = 0.01, 8, 1500.0, 1e-4
LAW = Elastic(1e6, 0.0)
SPEED = math.sqrt(LAW.young_modulus_Pa / DENSITY)
# steps in which the kinetic energy must not grow so much; a stable step only loses some. A hundredfold growth would
# pass steps that are above the stable one and by chance saturate below it
STEPS, GROWTH = 4000, 2.0
FACTORS = (0.5, 0.95, 1.2, 1.5, 1.8, 2.1, 2.5, 3.0)  # of the automatic step, for the silent error
SLIVER = 1e-3  # of a cell by which the body reaches into cells that are empty otherwise


class Block:
    """A free elastic block with random velocities; `sliver` pushes its edges a little into the next cells."""

    def __init__(self, shape, per_axis: int, sliver: bool):
        size, d = CELL * CELLS, CELL / per_axis
        # hat functions see points, the others domains: the outermost of them reach just over a grid line
        reach = 0.5 * d if shape.NODES == 2 and shape.PATCHES == 1 else 0.0
        shift = (SLIVER * CELL + reach) if sliver else 0.0
        self.particles, grid = block(
            width=size, height=size, cell=CELL, points_per_axis=per_axis, density=DENSITY,
            origin=(4 * CELL + shift, 4 * CELL + shift), box=(size + 8 * CELL, size + 8 * CELL),
            extra=Particles.extras(LAW, shape, Flip()),
        )  # fmt: skip
        noise = np.random.default_rng(2).normal(0.0, NOISE, (self.particles.count, 2))
        self.start = self.particles.arrays() | {"velocity": noise - noise.mean(axis=0)}
        self.body = solver(self.particles, grid, shape, LAW, simd=False)  # nodal velocities are fields there

    def survives(self, dt: float) -> bool:
        """Whether the energy stays bounded over some thousand steps."""
        self.particles.load(self.start)
        first = self.body.point_sums().kinetic_energy
        for _ in range(8):
            self.body.advance(STEPS // 8, dt)
            found = self.body.point_sums()
            if found.strays or not found.kinetic_energy < GROWTH * first:
                return False
        return True

    def criteria(self) -> dict[str, float]:
        """Time steps [s] by criterion in the first step."""
        self.particles.load(self.start)
        self.body.advance(1, 1e-3 * CELL / SPEED)
        return Criteria(self.body).take(1e-3 * CELL / SPEED)

    def limit(self) -> float:
        """Largest time step that survives [s], by bisection to 1 %."""
        low, high = 0.0, 2.0 * CELL / SPEED
        while high - low > 0.01 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.survives(middle) else (low, middle)
            if high < 1e-3 * CELL / SPEED:
                break
        return low


def explosion(shape, per_axis: int, sliver: bool) -> dict[str, float]:
    """The largest stable step, over h / c and over each criterion."""
    case = Block(shape, per_axis, sliver)
    limit = case.limit()
    return {"h / c": limit * SPEED / CELL} | {name: limit / step for name, step in case.criteria().items()}


def coarse_silo(cfl: float, points_per_cell: int = 1) -> float:
    """N in flow [N/m] of dense sand between smooth walls on 10 mm cells, lowered by 1 mm; inf if the run fails.
    The time step is `cfl` times h / (c + |v|).
    """
    scene = Scene(
        silo=Silo(width_m=0.1, height_m=0.3), walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=0.01, points_per_cell=points_per_cell),
        flow=Flow(speed_m_per_s=0.005, displacement_m=0.001), method=Method(cfl=cfl),
    )  # fmt: skip
    try:
        rows = [record.normal_N_per_m for record in Simulation(scene).run()]
    except RunFailed:
        return math.inf
    return float(np.mean(rows[-10:]))


def silence(points_per_cell: int, factors) -> tuple[float, float]:
    """Largest steps, over the automatic one, with N within 1 % of that at half of it, and with a finite N."""
    fraction = SHAPES["ugimp"](0.5 / math.isqrt(points_per_cell)).stable_fraction
    reference, right, alive = None, 0.0, 0.0
    still_right = True
    for factor in factors:
        normal = coarse_silo(factor * fraction, points_per_cell)
        if not math.isfinite(normal):
            break
        alive = factor
        reference = reference or normal
        still_right = still_right and abs(normal / reference - 1.0) < 0.01
        right = factor if still_right else right
    return right, alive


def scaled_silo(factor: float) -> dict[str, float]:
    """Dense sand between very rough walls on 20 mm cells, lowered by 2 mm at 2 mm/s, with mass scaling.

    Returns
    -------
    P, T, N at u = 1.5 to 2 mm [N/m], and steps.

    """
    scene = Scene(
        grid=Mesh(cell_size_m=0.02), flow=Flow(speed_m_per_s=0.002, displacement_m=0.002),
        method=Method(mass_scaling=factor),
    )  # fmt: skip
    simulation = Simulation(scene)
    rows = [record for record in simulation.run() if record.displacement_m > 0.0015]
    names = {"P": "bottom_N_per_m", "T": "shear_N_per_m", "N": "normal_N_per_m"}
    found = {key: float(np.mean([getattr(record, name) for record in rows])) for key, name in names.items()}
    return found | {"steps": simulation.clock.steps}


def measure(full: bool = True) -> list[Measurement]:
    """Explosion for each shape, points a cell, with and without nearly empty cells; then the silent error."""
    found = []
    shapes = SHAPES if full else {"ugimp": SHAPES["ugimp"], "linear": SHAPES["linear"]}
    for per_axis in (1, 2, 3) if full else (2,):
        for sliver in (False, True):
            where = f"{per_axis**2} points a cell" + (", nearly empty cells" if sliver else "")
            limits = {name: explosion(kind(0.5 / per_axis), per_axis, sliver) for name, kind in shapes.items()}
            for measure in ("h / c", *Criteria.NAMES):
                words = f"largest stable step over {measure}, {where}"
                bound = 0.4 if measure == "h / c" else 0.99  # bisected to 1 %
                values = {name: limit[measure] for name, limit in limits.items()}
                found += measurements(words, "-", ">=", bound, values)
    scaled = {factor: scaled_silo(factor) for factor in ((1, 10, 100, 1000) if full else ())}
    for force in ("P", "T", "N") if full else ():
        values = {
            f"{factor} times the mass": abs(forces[force] / scaled[1][force] - 1.0)
            for factor, forces in scaled.items() if factor > 1
        }  # fmt: skip
        found += measurements(f"mass scaling: change of {force}, very rough walls, 2 mm/s", "-", "<=", 0.02, values)
    for number, factors in ((1, FACTORS), (4, FACTORS[::2])) if full else ():
        right, alive = silence(number, factors)
        words = f"{number} point{'s' * (number > 1)} a cell"
        for measure, step in (("with N within 1 %", right), ("that does not explode", alive)):
            found += measurements(f"silo: step over auto {measure}, {words}", "-", ">=", 0.95, {"ugimp": step})
    return found
