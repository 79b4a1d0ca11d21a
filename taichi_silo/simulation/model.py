"""What of a silo is computed: its points, cells and walls, its law and its scales of time."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from taichi_silo.mpm.contracts import Filter, Law, Shape, Wall
from taichi_silo.mpm.felt_part import FeltPart
from taichi_silo.mpm.filters import FILTERS
from taichi_silo.mpm.geometry import Surroundings
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.mirrored_solver import MirroredSolver
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import NonLocal
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.patch_filter import PatchFilter
from taichi_silo.mpm.solver import Solver
from taichi_silo.mpm.walls import Gates, Surface
from taichi_silo.scene.outlets import Opening
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.stress_filter import filter_of
from taichi_silo.simulation.section import Section
from taichi_silo.simulation.wall_forces import WallForces


@dataclass(frozen=True)
class Model:
    """A silo, discretised (see `discretise`); what changes in time is the state of the points and of the grid.

    Attributes
    ----------
    scene : what the user gave.
    section : the part of the silo that is computed.
    law, shape : constitutive law and shape functions.
    spacing : of the points in the fill [m].
    density : of the fill, inertial: with mass scaling the grains are heavier and gravity smaller [kg/m3].
    gravity : [m/s2].
    wave_speed : of a plane wave at half the height of the filled silo, an upper bound [m/s].
    period : of the slowest swing of the fill [s].
    filling_time, flow_time : duration of the filling without the rest after it, and of the flow at most [s].
    control : noise control.
    fill : makes the fields of the computed points of the full silo, without stress.
    mass : of the full silo [kg/m].
    particles, grid : the state.
    averaging : the non-local average, None where the law is local; `about_averaging` is a sentence that says why.
    walls, surfaces : walls on lines of the grid, and those that are not.
    wall_forces : the forces of both.
    openings : where sand leaves, in the frame of the grid; none where the whole floor sinks.
    gates : what moves the gates of several outlets; None where all move with the plate velocity.

    """

    scene: Scene
    section: Section
    law: Law
    shape: Shape
    spacing: float
    density: float
    gravity: float
    wave_speed: float
    period: float
    filling_time: float
    flow_time: float
    control: NoiseControl
    fill: Callable[[], dict[str, np.ndarray]]
    mass: float
    particles: Particles
    grid: Grid
    averaging: NonLocal | None
    about_averaging: str
    walls: tuple[Wall, ...]
    surfaces: tuple[Surface, ...]
    wall_forces: WallForces
    openings: tuple[Opening, ...] = ()
    gates: Gates | None = None

    @property
    def interval(self) -> float:
        """Time between records [s]."""
        return self.period / self.scene.output.records_per_period

    def gate_shares(self, shares: tuple[float, ...]) -> np.ndarray | None:
        """Shares of the solver's walls on grid lines (walls,) from those of gates; None where nothing has its own."""
        if self.gates is None or not shares:
            return None
        first = len(self.walls) - 2 * len(shares)
        return np.concatenate([np.ones(first), np.repeat(shares, 2)])

    def solver(self, control: NoiseControl) -> Solver:
        """A solver that steps the model with this noise control."""
        return (MirroredSolver if self.section.half else Solver)(
            self.particles, self.grid, self.shape, self.law, self.walls, control, averaging=self.averaging,
            surroundings=Surroundings(self.section.geometry), surfaces=self.surfaces,
            friction_delay_s=0.0,  # what that is against, sand and the noise control's drag damp in a silo
            simd=None if self.scene.machine.lanes else False,
            **self.scene.method.solver_options() | {"filtering": self._filtering()},
        )  # fmt: skip

    def _filtering(self) -> Filter | None:
        """The class of the filter; beside walls that cut cells the patch filter leaves what nodes feel."""
        filtering = FILTERS[filter_of(self.scene)[0]]
        if filtering is not PatchFilter or not self.surfaces:
            return filtering
        return partial(PatchFilter, felt=FeltPart(self.particles, self.grid, self.shape, self.section.geometry))
