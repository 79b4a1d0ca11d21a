"""Failure mode 5: time steps that are too long, and those that are wrong before anything explodes."""

import math

import numpy as np

from taichi_silo.laws import Elastic
from taichi_silo.particles import Particles
from taichi_silo.scene import Flow, Mesh, Method, Scene, Silo, Walls
from taichi_silo.shapes import SHAPES
from taichi_silo.simulation import Simulation
from taichi_silo.stability.bodies import block, solver
from taichi_silo.stability.cell import Cell, cells_of
from taichi_silo.timestep import Criteria
from taichi_silo.transfers import Flip

MODE = "5 time step"
CELL, CELLS, DENSITY, NOISE = 0.01, 8, 1500.0, 1e-4
LAW = Elastic(1e6, 0.0)
SPEED = math.sqrt(LAW.young_modulus_Pa / DENSITY)
STEPS, GROWTH = 4000, 100.0  # steps in which the energy must not grow so much
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
        self.body = solver(self.particles, grid, shape, LAW)

    def survives(self, dt: float) -> bool:
        """Whether the energy stays bounded over some thousand steps."""
        self.particles.load(self.start)
        first = self.body.survey().kinetic_energy
        for _ in range(8):
            self.body.advance(STEPS // 8, dt)
            found = self.body.survey()
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


def coarse_silo(cfl: float, points_per_cell: int = 1) -> dict[str, float]:
    """Dense sand between smooth walls on 10 mm cells, filled and lowered by 1 mm with a given time step.

    Returns
    -------
    normal: N in flow [N/m]; path: path length of the strain in the core during the flow [-].

    """
    scene = Scene(
        silo=Silo(width_m=0.1, height_m=0.3), walls=Walls(kind="smooth"),
        grid=Mesh(cell_size_m=0.01, points_per_cell=points_per_cell),
        flow=Flow(speed_m_per_s=0.005, displacement_m=0.001), method=Method(cfl=cfl),
    )  # fmt: skip
    simulation = Simulation(scene)
    for _record in simulation.fill():
        pass
    before = simulation.particles.arrays()["path"]
    rows = [record.normal_N_per_m for record in simulation.flow()]
    core = simulation.points()["position"][:, 1] < 0.2
    grown = simulation.particles.arrays()["path"] - before
    return {"normal": float(np.mean(rows[-10:])), "path": float(grown[core].mean())}


def silence(points_per_cell: int, factors=(0.5, 0.95, 1.2, 1.5, 1.8, 2.1, 2.5, 3.0)) -> tuple[float, float]:
    """Largest steps, over the automatic one, with N within 1 % of that at half of it, and with a finite N."""
    fraction = SHAPES["ugimp"](0.5 / math.isqrt(points_per_cell)).stable_fraction
    reference, right, alive = None, 0.0, 0.0
    still_right = True
    for factor in factors:
        normal = coarse_silo(factor * fraction, points_per_cell)["normal"]
        if not math.isfinite(normal):
            break
        alive = factor
        reference = reference or normal
        still_right = still_right and abs(normal / reference - 1.0) < 0.01
        right = factor if still_right else right
    return right, alive


def cells(full: bool = True) -> list[Cell]:
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
                found += cells_of(MODE, words, "-", ">=", bound, values)
    for number in (1, 4) if full else ():
        right, alive = silence(number)
        words = f"{number} point{'s' * (number > 1)} a cell"
        for measure, step in (("with N within 1 %", right), ("that does not explode", alive)):
            found += cells_of(MODE, f"silo: step over auto {measure}, {words}", "-", ">=", 0.95, {"ugimp": step})
    return found
