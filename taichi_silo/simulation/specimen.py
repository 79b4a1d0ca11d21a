"""A body of sand between two plates, under the pressure of a fluid: what element tests and the biaxial test load.

The grid's height follows the upper plate, so that both plates always lie on nodes; the fluid's pressure acts on every
free surface, wherever that moves (see `geometry.Surroundings`).
"""

import math
from dataclasses import dataclass

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.geometry import Axisymmetric, PlaneStrain, Surroundings
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import NonLocal
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import threads
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.solver import Solver
from taichi_silo.mpm.walls import NoSlip
from taichi_silo.scene.method_options import MethodOptions

STEP_SAFETY = 0.9  # of the stable step, which changes within an interval


@dataclass(frozen=True)
class Reading:
    """State at the end of an interval; means are weighted with the points' volumes, compression positive."""

    time_s: float
    travel_m: float  # of the upper plate, upwards (or along itself in shear)
    height_m: float  # distance of the plates
    stress_Pa: np.ndarray  # mean (xx, yy, zz, xy), tension positive
    void_ratio: float
    plate_force_N: np.ndarray  # mean of the upper plate on the sand over the interval (x, y), beyond the fluid's
    kinetic_energy_J: float
    time_step_s: float
    stable_step_s: float  # at the end


class Specimen:
    """Points on a regular lattice in [left, left + width] x [0, height], and the solver that moves them.

    Parameters
    ----------
    law : of `taichi_silo.laws`.
    void_ratio : number, or one for each point by rows from below (see `lattice`).
    width_m, height_m, cell_size_m, per_axis : size, cells, points along the edge of a cell.
    walls : function of the grid that returns the walls; the last one is the upper plate.
    stress : (xx, yy, zz, xy) [Pa] for each point, or one for all.
    ambient_pressure : of the fluid [Pa].
    left_m : free width to the left of the body (and to its right, unless `right_m` says otherwise).
    axisymmetric : whether x is a radius.
    follows, periodic : see `Grid`; fields of a periodic body are alike along x.
    gravity : [m/s2].
    kernel : of the non-local average, or None.
    rigid_walls : whether walls of no slip count in it (see `Means`).
    by : whether it is summed over "rows" of neighbours, or by a "grid"; None: the faster one.
    control : noise control.
    shape, options : of the method.
    h : intergranular strain at the start, for a law that remembers.

    """

    def __init__(
        self, law, void_ratio, *, width_m, height_m, cell_size_m, walls, stress, per_axis=1, ambient_pressure=0.0,
        left_m=0.0, right_m=None, axisymmetric=False, follows="top", periodic=False, gravity=0.0, kernel=None,
        rigid_walls=False, by=None, control: NoiseControl | None = None, shape="ugimp",
        options: MethodOptions | None = None, h=(0.0,) * 4,
    ):  # fmt: skip
        self.law, self.gravity, self.options = law, gravity, options or MethodOptions()
        right_m = left_m if right_m is None else right_m
        geometry = Axisymmetric() if axisymmetric else PlaneStrain()
        grid = Grid(left_m + width_m + right_m, height_m, cell_size_m, threads(), follows, periodic)
        place = self.lattice(width_m, height_m, cell_size_m, per_axis) + np.array([left_m, 0.0])
        count, spacing = len(place), cell_size_m / per_axis
        shape = SHAPES[shape](0.5 / per_axis)
        e = np.broadcast_to(np.asarray(void_ratio, dtype=float), count)
        volume = spacing**2 * geometry.depth(place[:, 0])
        self.particles = Particles(count, Particles.extras(law, shape, self.options.transfer_of_points()))
        state = {
            "position": place,
            "velocity": np.zeros((count, 2)),
            "stress": np.broadcast_to(np.asarray(stress, dtype=float), (count, 4)),
            "mass": law.grain_density / (1.0 + e) * volume,
            "volume": volume,
            "path": np.zeros(count),
            "domain": np.tile([spacing, 0.0, 0.0, spacing], (count, 1)),
        }
        if law.REMEMBERS:
            state["intergranular"] = np.broadcast_to(np.asarray(h, dtype=float), (count, 4))
        self.particles.load(state)
        found = walls(grid)
        rigid = [wall.plane(grid) for wall in found if rigid_walls and isinstance(wall.contact, NoSlip)]
        self.solver = Solver(
            self.particles, grid, shape, law, found, control or NoiseControl(),
            averaging=NonLocal(
                kernel, self.particles, spacing, rigid_planes=rigid, alike_along_x=periodic, grid=grid, by=by
            ) if kernel else None,
            surroundings=Surroundings(geometry, ambient_pressure), friction_delay_s=0.0,
            **self.options.solver_options(),
        )  # fmt: skip
        self.time = self.travel = 0.0
        self.steps = 0
        self.speed = 0.0

    @staticmethod
    def lattice(width_m, height_m, cell_size_m, per_axis=1) -> np.ndarray:
        """Places of the points, by rows from below."""
        d = cell_size_m / per_axis
        x, y = np.meshgrid(
            (np.arange(round(width_m / d)) + 0.5) * d, (np.arange(round(height_m / d)) + 0.5) * d
        )  # fmt: skip
        return np.stack([x.ravel(), y.ravel()], axis=1)

    def drive(self, duration_s: float, speed_m_per_s: float) -> Reading:
        """Let the plate's speed go linearly from what it was to `speed_m_per_s` (upwards, or along x in shear).

        Raises
        ------
        RunFailed
            if points left the grid or are not finite.

        """
        solver = self.solver
        step = self.options.time_step(solver.point_sums(), STEP_SAFETY)
        steps = max(1, math.ceil(duration_s / step - 1e-9))
        dt = duration_s / steps
        solver.advance(steps, dt, (self.gravity, self.gravity), (self.speed, speed_m_per_s))
        reaction, _ = solver.impulses.read_and_reset()
        self.time += duration_s
        self.travel += 0.5 * (self.speed + speed_m_per_s) * duration_s
        self.steps += steps
        self.speed = speed_m_per_s
        found = solver.point_sums()
        points = self.particles.arrays()
        if found.strays or not np.isfinite(points["stress"]).all():
            raise RunFailed(
                f"at t = {self.time:.5f} s, plate travel {1e3 * self.travel:.3f} mm: {found.strays} points "
                f"left the grid or are not finite; a time step too large is the likely cause (it was {1e6 * dt:.2f} us)"
            )
        share = points["volume"] / points["volume"].sum()
        grains = points["mass"].sum() / self.law.grain_density
        return Reading(
            time_s=self.time,
            travel_m=self.travel,
            height_m=solver.grid.present_height,
            stress_Pa=share @ points["stress"],
            void_ratio=float(points["volume"].sum() / grains - 1.0),
            plate_force_N=reaction[-1].sum(axis=0) / duration_s if solver.walls else np.zeros(2),
            kinetic_energy_J=found.kinetic_energy,
            time_step_s=dt,
            stable_step_s=found.stable_step,
        )
