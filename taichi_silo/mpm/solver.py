"""The explicit step, in the order of the paper's section 3."""

from types import SimpleNamespace

import numpy as np
import taichi as ti

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.filters import Unfiltered
from taichi_silo.mpm.g2p import affine_of, at_point, deform, gather, gradient_of, move, respond, scatter, second_scatter
from taichi_silo.mpm.geometry import Surroundings
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.grid_update import integrate_node, second_velocity_of_node
from taichi_silo.mpm.loops import NODES, POINTS, Loops
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import Local
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.point_sums import PointSums
from taichi_silo.mpm.runtime import real
from taichi_silo.mpm.simd import Lanes
from taichi_silo.mpm.simd_selftest import failure
from taichi_silo.mpm.tensors import norm
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls.surfaces import NoSurfaces, Surfaces

STRESS_UPDATES = ("last", "first", "modified")


@ti.data_oriented
class Impulses:
    """Impulses booked since they were last read [N s/m].

    reaction (wall, slot along the wall): impulse that each wall gives to the sand.
    control (grid row): impulse of the noise control on the sand.
    """

    def __init__(self, walls: int, grid: Grid):
        self.reaction = ti.field(real, shape=(max(walls, 1), max(grid.columns, grid.rows), 2))
        self.control = ti.field(real, shape=(grid.rows, 2))

    @ti.func
    def add_wall(self, wall, slot, impulse, shared: ti.template()):
        """A wall has given the sand an impulse."""
        for c in ti.static(range(2)):
            if ti.static(shared):
                self.reaction[wall, slot, c] += impulse[c]
            else:
                self.reaction[wall, slot, c] = self.reaction[wall, slot, c] + impulse[c]

    @ti.func
    def add_damping(self, row, impulse, shared: ti.template()):
        """The noise control has given a row of nodes an impulse."""
        for c in ti.static(range(2)):
            if ti.static(shared):
                self.control[row, c] += impulse[c]
            else:
                self.control[row, c] = self.control[row, c] + impulse[c]

    def read_and_reset(self) -> tuple[np.ndarray, np.ndarray]:
        """Reaction (walls, slots, 2) and control (rows, 2), and start anew."""
        gathered = self.reaction.to_numpy(), self.control.to_numpy()
        self.reaction.fill(0.0)
        self.control.fill(0.0)
        return gathered


@ti.data_oriented
class Solver(Loops):
    """Explicit material point method.

    Parameters
    ----------
    particles, grid : the state.
    shape : of `taichi_silo.shapes`.
    law : of `taichi_silo.laws`.
    walls : tuple of walls of `taichi_silo.walls`, applied in this order.
    control : noise control.
    down : unit vector along which gravity acts.
    averaging : `Local()`, or a `NonLocal` of the same particles.
    surroundings : geometry and ambient pressure.
    transfer : of `taichi_silo.transfers`.
    stress_update : "last", from the velocities that the nodes have after the step (Bardenhagen 2002); "first", from
        those before it; "modified", last, from velocities that the points have given to the nodes once more (Sulsky
        et al. 1995).
    filtering : a class of `taichi_silo.filters`, or None.
    shared : see `Loops`; None chooses.
    surfaces : walls of `taichi_silo.walls.surfaces` that do not follow the grid.
    lanes : whether eight points go at once (see lanes.py); None: wherever that is possible and proved (proof.py).

    """

    def __init__(
        self, particles: Particles, grid: Grid, shape, law, walls=(), control: NoiseControl | None = None,
        down=(0.0, -1.0), averaging=None, surroundings: Surroundings | None = None, shared: bool | None = None,
        transfer=None, stress_update: str = "last", filtering=None, lanes: bool | None = None, surfaces=(),
    ):  # fmt: skip
        self.particles, self.grid, self.shape, self.law = particles, grid, shape, law
        self.walls, self.control = tuple(walls), control or NoiseControl()
        self.averaging, self.surroundings = averaging or Local(), surroundings or Surroundings()
        self.transfer = transfer or Flip()
        self.second_walls = () if self.transfer.SECOND_TRANSFER else self.walls
        self.filter = filtering(particles, grid, law) if filtering else Unfiltered()
        self.down = float(down[0]), float(down[1])
        self.stress_update = stress_update
        super().__init__(shared)
        self.surfaces = NoSurfaces()
        if surfaces:
            density = float(particles.mass[0] / particles.volume[0])
            self.surfaces = Surfaces(surfaces, grid, density, len(self.walls), self.surroundings.geometry.depth)
        phases = self._with_surfaces(self.program(stress_update))
        self.phases = tuple((number, *phase) for number, phase in enumerate(phases))
        self.impulses = Impulses(len(self.walls) + len(surfaces), grid)
        self.stable_fraction = shape.stable_fraction
        self.sums = PointSums(particles, grid, law, self.shared)
        hindrance = Lanes.why_not(self)
        if lanes and hindrance:
            raise ValueError(f"the step cannot run on lanes because {hindrance}")
        wanted = lanes is None and not shared and not hindrance
        self.distrust = failure() if wanted else ""  # why lanes that could be used are not
        self.lanes = Lanes(self) if lanes or (wanted and not self.distrust) else None

    MIRRORED = False  # whether nodes beyond the last column of the grid are images of those before it (half.py)

    # --- the step -----------------------------------------------------------------------------------------------

    def program(self, stress_update: str) -> list[tuple]:
        """The phases of a step in their order: over points or nodes, function, its option."""
        if stress_update not in STRESS_UPDATES:
            raise ValueError(f"stress update is {stress_update!r}; it must be one of {', '.join(STRESS_UPDATES)}")
        if self.transfer.SECOND_TRANSFER and stress_update != "last":
            raise ValueError(f"stress update is {stress_update!r}; with the transfer {self.transfer} it must be 'last'")
        velocity, second = self.grid.velocity, self.grid.second_velocity
        then = [(POINTS, self._respond, None)] if self.averaging.ACTIVE else []
        then += self.filter.phases() if self.filter.ACTIVE else []
        if stress_update == "first":
            return [
                (POINTS, self._scatter, "motion"),
                (NODES, self._second_velocity, "keeps sums"),
                (POINTS, self._stress, second),
                *then,
                (POINTS, self._scatter, "force"),
                (NODES, self._integrate, "last"),
                (POINTS, self._move, second),
            ]
        if stress_update == "modified" or self.transfer.SECOND_TRANSFER:
            return [
                (POINTS, self._scatter, "all"),
                (NODES, self._integrate, "keeps mass"),
                (POINTS, self._send_back, None),
                (NODES, self._second_velocity, "last"),
                (POINTS, self._gather, velocity if self.transfer.SECOND_TRANSFER else second),
                *then,
            ]
        return [
            (POINTS, self._scatter, "all"),
            (NODES, self._integrate, "last"),
            (POINTS, self._gather, velocity),
            *then,
        ]

    def _with_surfaces(self, phases: list[tuple]) -> list[tuple]:
        """The phases, with that of the surfaces after the nodes have moved."""
        if not self.surfaces.ACTIVE:
            return phases
        moved = max(number for number, phase in enumerate(phases) if phase[1] == self._integrate) + 1
        return [*phases[:moved], (NODES, self._press, None), *phases[moved:]]

    def advance(self, steps: int, dt: float, gravity=(0.0, 0.0), plate_velocity=(0.0, 0.0), filling_drag=0.0) -> None:
        """Do `steps` steps of `dt` seconds.

        `gravity` and `plate_velocity` are pairs, at the beginning and the end, and vary linearly between.
        """
        schedule = (*map(float, gravity), *map(float, plate_velocity), filling_drag)
        if steps == 0 or not self.averaging.ACTIVE:
            self.run(0, steps, steps, dt, *schedule)
            return
        done = 0
        while done < steps:
            self.averaging.refresh()
            fastest = self.point_sums().speed + max(map(abs, plate_velocity))
            chunk = min(steps - done, self.averaging.steps_within(fastest, dt))
            self.run(done, chunk, steps, dt, *schedule)
            done += chunk

    def point_sums(self) -> SimpleNamespace:
        """What `PointSums` finds, and `stable_step`: the shape's stable fraction of the least h / (c + |v|) [s].

        Raises
        ------
        RunFailed
            if a thread waited in vain for the others.

        """
        if self.barrier.lost():
            raise RunFailed("because the threads of a step lost each other; use fewer on a machine this busy")
        found = self.sums.read()
        found.stable_step = found.transit * self.stable_fraction
        return found

    # --- its phases: of points (p, t, step, option, shared), of nodes (i, j, step, option, shared) ------------------

    @ti.func
    def _scatter(self, p, t, step, what: ti.template(), shared: ti.template()):
        """Particles to grid: mass and momentum ("motion"), internal force ("force"), or "all"."""
        scatter(
            self.particles, self.grid, self.shape, self.transfer, self.surroundings, p, t,
            what != "force", what != "motion", shared,
        )  # fmt: skip

    @ti.func
    def _integrate(self, i, j, step, what: ti.template(), shared: ti.template()):
        """Equation of motion of a node, noise control, walls."""
        integrate_node(
            self.grid, self.walls, self.surfaces, self.control, self.impulses, self.down, i, j, step, what == "last",
            shared,
        )  # fmt: skip

    @ti.func
    def _press(self, i, j, step, option: ti.template(), shared: ti.template()):
        """New tractions of the surfaces."""
        if i == 0:
            self.surfaces.press_row(j, step.dt)

    @ti.func
    def _send_back(self, p, t, step, option: ti.template(), shared: ti.template()):
        """To the nodes once more: the point's new velocity, or (XPIC) the old one as the grid saw it."""
        v = at_point(self.particles, self.grid, self.shape, self.grid.velocity, p, t)
        dv = at_point(self.particles, self.grid, self.shape, self.grid.change, p, t)
        given = v - dv
        if ti.static(not self.transfer.SECOND_TRANSFER):
            given = self.transfer.carried(self.particles.velocity[p], v, dv, v, step.dt)
        second_scatter(self.particles, self.grid, self.shape, p, t, given, shared)

    @ti.func
    def _second_velocity(self, i, j, step, what: ti.template(), shared: ti.template()):
        """Velocity of a node from its sums alone; what strains the sand also obeys the walls."""
        second_velocity_of_node(self.grid, self.second_walls, i, j, step, what == "last")

    @ti.func
    def _gather(self, p, t, step, field: ti.template(), shared: ti.template()):
        """Grid to particles: motion, and stress from the gradient of a nodal velocity."""
        self.update_point(0, p, t, step, self._gathered(p, t, field), True, True)

    @ti.func
    def _stress(self, p, t, step, field: ti.template(), shared: ti.template()):
        """Grid to particles: stress only."""
        self.update_point(0, p, t, step, self._gathered(p, t, field), False, True)

    @ti.func
    def _move(self, p, t, step, field: ti.template(), shared: ti.template()):
        """Grid to particles: motion only."""
        self.update_point(0, p, t, step, self._gathered(p, t, field), True, False)

    @ti.func
    def _respond(self, p, t, step, option: ti.template(), shared: ti.template()):
        """Stress of point p under the non-local norm of the strain rate."""
        self.update_stress(0, p, step, self.averaging.mean(p))

    # --- a point p, or a group p of lanes -----------------------------------------------------------------------

    @ti.func
    def _gathered(self, p, t, field: ti.template()):
        """What point p takes of the grid; if the transfer is affine, also its affine field."""
        if ti.static(self.transfer.GRADIENT == "affine"):
            self.particles.write(0, "affine", p, affine_of(self.particles, self.grid, self.shape, p, t))
        return gather(self.particles, self.grid, self.shape, field, p, t)

    @ti.func
    def _returned(self, p, t, gathered):
        """What came back from the nodes; the velocity itself if the transfer sends nothing there."""
        if ti.static(self.transfer.SECOND_TRANSFER):
            back = at_point(self.particles, self.grid, self.shape, self.grid.second_velocity, p, t)
            return back[0], back[1]
        return gathered[0], gathered[1]

    @ti.func
    def update_point(self, lanes: ti.template(), p, t, step, gathered, motion: ti.template(), stress: ti.template()):
        """Motion, and stress, of a point that has gathered its eight slots from the grid (see phases.py)."""
        L = gradient_of(self.particles, self.grid, self.surroundings.geometry, lanes, p, t, gathered)
        if ti.static(motion):
            move(
                self.particles, self.grid, self.transfer, self.control, lanes, p, step, gathered,
                self._returned(p, t, gathered),
            )  # fmt: skip
            deform(self.particles, self.grid, self.shape, self.transfer, lanes, p, t, L, step.dt)
        if ti.static(stress):
            D, spin = (L[0], L[3], L[4], 0.5 * (L[1] + L[2])), 0.5 * (L[1] - L[2])
            length = norm(D)
            if ti.static(self.averaging.ACTIVE):  # it waits for the neighbours' strain rates
                self.averaging.keep(lanes, p, D, spin, length)
            else:
                respond(self.particles, self.law, lanes, p, D, spin, length, length, step.dt)

    @ti.func
    def update_stress(self, lanes: ti.template(), p, step, d_bar):
        """Stress of a point whose strain rate was kept, with the non-local norm d_bar [1/s]."""
        d0, d1, d2, d3, spin, length = self.averaging.kept(lanes, p)
        respond(self.particles, self.law, lanes, p, (d0, d1, d2, d3), spin, length, d_bar, step.dt)
