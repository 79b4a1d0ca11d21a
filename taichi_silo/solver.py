"""The explicit step, in the order of the paper's section 3, and the loops over points and nodes."""

from types import SimpleNamespace

import numpy as np
import taichi as ti

from taichi_silo import runtime
from taichi_silo.averaging import Local
from taichi_silo.faults import RunFailed
from taichi_silo.geometry import Setting
from taichi_silo.grid import Grid
from taichi_silo.noise import NoiseControl
from taichi_silo.particles import Particles
from taichi_silo.runtime import real
from taichi_silo.tensors import norm, trace
from taichi_silo.transfer import integrate_node, move, respond, scatter

SPIN_LIMIT = 500_000_000  # turns of a waiting thread before it gives up (some seconds)
LOST = 32  # slot of `arrivals` that says that one did


@ti.dataclass
class Step:
    """What varies from step to step."""

    dt: real  # [s]
    gravity: real  # [m/s2]
    plate_velocity: real  # of the moving plates [m/s]
    filling_drag: real  # [1/s]


@ti.data_oriented
class Books:
    """Impulses booked since they were last read [N s/m].

    reaction (wall, slot along the wall): impulse that each wall gives to the sand.
    control (grid row): impulse of the noise control on the sand.
    """

    def __init__(self, walls: int, grid: Grid):
        self.reaction = ti.Vector.field(2, real, shape=(max(walls, 1), max(grid.columns, grid.rows)))
        self.control = ti.Vector.field(2, real, shape=grid.rows)

    def take(self) -> tuple[np.ndarray, np.ndarray]:
        """Reaction (walls, slots, 2) and control (rows, 2), and start anew."""
        taken = self.reaction.to_numpy(), self.control.to_numpy()
        self.reaction.fill(0.0)
        self.control.fill(0.0)
        return taken


@ti.data_oriented
class Solver:
    """Explicit material point method, stress updated last.

    Parameters
    ----------
    particles, grid : the state.
    shape : of `taichi_silo.shapes`.
    law : of `taichi_silo.laws`.
    walls : tuple of walls of `taichi_silo.walls`, applied in this order.
    control : noise control.
    down : unit vector along which gravity acts.
    averaging : `Local()`, or a `NonLocal` of the same particles.
    setting : geometry and ambient pressure.
    shared : one launch a phase with atomic sums, as on a GPU; the default on the CPU gives every thread its own
        strip of points and copy of the sums, and many steps a launch.

    """

    def __init__(
        self, particles: Particles, grid: Grid, shape, law, walls=(), control: NoiseControl | None = None,
        down=(0.0, -1.0), averaging=None, setting: Setting | None = None, shared: bool | None = None,
    ):  # fmt: skip
        self.particles, self.grid, self.shape, self.law = particles, grid, shape, law
        self.walls, self.control = tuple(walls), control or NoiseControl()
        self.averaging, self.setting = averaging or Local(), setting or Setting()
        self.down = ti.Vector([float(down[0]), float(down[1])])
        self.shared = not runtime.is_cpu() if shared is None else shared
        self.threads = 1 if self.shared else runtime.threads()
        if not self.shared and grid.copies != self.threads:
            raise ValueError(f"grid has {grid.copies} copies of its sums; {self.threads} threads need as many")
        self.books = Books(len(self.walls), grid)
        self.arrivals = ti.field(ti.i32, shape=64)
        self.passed = 0
        self.found = ti.field(real, shape=8)

    # --- the step -----------------------------------------------------------------------------------------------

    def advance(self, steps: int, dt: float, gravity=(0.0, 0.0), plate_velocity=(0.0, 0.0), filling_drag=0.0) -> None:
        """Do `steps` steps of `dt` seconds.

        `gravity` and `plate_velocity` are pairs, at the beginning and the end, and vary linearly between.
        """
        schedule = (*map(float, gravity), *map(float, plate_velocity), filling_drag)
        if steps == 0 or not self.averaging.ACTIVE:
            self._advance(0, steps, steps, dt, *schedule)
            return
        done = 0
        while done < steps:
            self.averaging.refresh()
            fastest = self.survey().speed + max(map(abs, plate_velocity))
            chunk = min(steps - done, self.averaging.steps_within(fastest, dt))
            self._advance(done, chunk, steps, dt, *schedule)
            done += chunk

    def _advance(self, done: int, count: int, steps: int, dt: float, *schedule: float) -> None:
        if self.shared:
            for number in range(done, done + count):
                self._step_shared(number, steps, dt, *schedule)
        elif self.threads == 1:
            self._steps_alone(done, count, steps, dt, *schedule)
        else:
            if self.passed > 1_000_000_000:
                self.arrivals.fill(0)
                self.passed = 0
            self._steps_together(done, count, steps, dt, *schedule, self.passed)
            self.passed += self.waits * self.threads * count

    @property
    def waits(self) -> int:
        """How often the threads wait for each other in a step."""
        return 3 if self.averaging.ACTIVE else 2

    @ti.func
    def _at(self, number, steps, dt, g0, g1, v0, v1, filling_drag):
        part = (number + 0.5) / steps
        return Step(
            dt=dt, gravity=g0 + part * (g1 - g0), plate_velocity=v0 + part * (v1 - v0), filling_drag=filling_drag
        )

    @ti.func
    def _scatter(self, p, t, shared: ti.template()):
        scatter(self.particles, self.grid, self.shape, self.setting, p, t, shared)

    @ti.func
    def _integrate(self, i, j, step, shared: ti.template()):
        integrate_node(self.grid, self.walls, self.control, self.books, self.down, i, j, step, shared)

    @ti.func
    def _gather(self, p, step, t):
        """Motion of point p, and its stress unless that waits for the neighbours' strain rates."""
        xx, yy, zz, xy, spin = move(
            self.particles, self.grid, self.shape, self.control, self.setting, p, step, t
        )  # fmt: skip
        length = norm((xx, yy, zz, xy))
        if ti.static(self.averaging.ACTIVE):
            self.averaging.motion[p] = ti.Vector([xx, yy, zz, xy, spin])
            self.averaging.norm[p] = length
        else:
            respond(self.particles, self.law, p, (xx, yy, zz, xy), spin, length, length, step.dt)

    @ti.func
    def _respond(self, p, step):
        """Stress of point p under the non-local norm of the strain rate."""
        L = self.averaging.motion[p]
        length, mean = self.averaging.norm[p], self.averaging.mean(p)
        respond(self.particles, self.law, p, (L[0], L[1], L[2], L[3]), L[4], length, mean, step.dt)

    @ti.kernel
    def _step_shared(
        self, number: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real, filling_drag: real
    ):
        for p in range(self.particles.count):
            self._scatter(p, 0, True)
        for k in range(self.grid.nodes):
            step = self._at(number, steps, dt, g0, g1, v0, v1, filling_drag)
            j = k // self.grid.columns
            self._integrate(k - j * self.grid.columns, j, step, True)
        for p in range(self.particles.count):
            self._gather(p, self._at(number, steps, dt, g0, g1, v0, v1, filling_drag), 0)
        if ti.static(self.averaging.ACTIVE):
            for p in range(self.particles.count):
                self._respond(p, self._at(number, steps, dt, g0, g1, v0, v1, filling_drag))
        for t in range(1):
            self.grid.follow(t, self._at(number, steps, dt, g0, g1, v0, v1, filling_drag))

    @ti.kernel
    def _steps_alone(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real,
    ):  # fmt: skip
        ti.loop_config(serialize=True)
        for number in range(done, done + count):
            step = self._at(number, steps, dt, g0, g1, v0, v1, filling_drag)
            for p in range(self.particles.count):
                self._scatter(p, 0, False)
            for j in range(self.grid.rows):
                for i in range(self.grid.columns):
                    self._integrate(i, j, step, False)
            for p in range(self.particles.count):
                self._gather(p, step, 0)
            if ti.static(self.averaging.ACTIVE):
                for p in range(self.particles.count):
                    self._respond(p, step)
            self.grid.follow(0, step)

    @ti.kernel
    def _steps_together(
        self, done: ti.i32, count: ti.i32, steps: ti.i32, dt: real, g0: real, g1: real, v0: real, v1: real,
        filling_drag: real, passed: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for t in range(self.threads):
            first, last = t * self.particles.count // self.threads, (t + 1) * self.particles.count // self.threads
            low, high = t * self.grid.rows // self.threads, (t + 1) * self.grid.rows // self.threads
            for number in range(count):
                step = self._at(done + number, steps, dt, g0, g1, v0, v1, filling_drag)
                arrivals = passed + self.threads * self.waits * number
                for p in range(first, last):
                    self._scatter(p, t, False)
                self._wait(arrivals + self.threads)
                for j in range(low, high):
                    for i in range(self.grid.columns):
                        self._integrate(i, j, step, False)
                self._wait(arrivals + 2 * self.threads)
                for p in range(first, last):
                    self._gather(p, step, t)
                if ti.static(self.averaging.ACTIVE):
                    self._wait(arrivals + 3 * self.threads)
                    for p in range(first, last):
                        self._respond(p, step)
                self.grid.follow(t, step)

    @ti.func
    def _wait(self, arrivals):
        """Wait until all threads have arrived."""
        ti.atomic_add(self.arrivals[0], 1)
        turns = 0
        while ti.atomic_max(self.arrivals[0], -1) < arrivals and turns < SPIN_LIMIT and self.arrivals[LOST] == 0:
            turns += 1  # the maximum with -1 is an atomic load
        if turns >= SPIN_LIMIT:
            self.arrivals[LOST] = 1

    # --- what observers ask ---------------------------------------------------------------------------------------

    def survey(self) -> SimpleNamespace:
        """Sums and extremes over the points, in one pass.

        Returns
        -------
        kinetic_energy [J/m], momentum (vertical) [kg m/s /m], stable_step: h / (c + |v|) times the shape's stable
        fraction, least over the points [s]; void_ratio_low: least; separated: points that carry no stress;
        strays: points outside the grid or not finite; speed: greatest [m/s].

        Raises
        ------
        RunFailed
            if a thread waited in vain for the others.

        """
        if self.threads > 1 and self.arrivals[LOST]:
            raise RunFailed("because the threads of a step lost each other; use fewer on a machine this busy")
        self._survey()
        energy, momentum, step, low, separated, strays, speed, _ = self.found.to_numpy()
        return SimpleNamespace(
            kinetic_energy=energy, momentum=momentum, stable_step=step * self.shape.stable_fraction,
            void_ratio_low=low, separated=int(separated), strays=int(strays), speed=speed,
        )  # fmt: skip

    @ti.kernel
    def _survey(self):
        for _ in range(1):
            self.found[0], self.found[1], self.found[4], self.found[5], self.found[6] = 0.0, 0.0, 0.0, 0.0, 0.0
            self.found[2], self.found[3] = 1e30, 1e30
        if ti.static(not self.shared):
            ti.loop_config(serialize=True)  # sums in a fixed order, so that runs repeat themselves
        for p in range(self.particles.count):
            v, x, s = self.particles.velocity[p], self.particles.position[p], self.particles.stress[p]
            m, volume = self.particles.mass[p], self.particles.volume[p]
            e = volume * self.law.grain_density / m - 1.0
            speed = v.norm()
            c = ti.sqrt(self.law.stiffness((s[0], s[1], s[2], s[3]), e) * (1.0 + e) / self.law.grain_density)
            self.found[0] += 0.5 * m * speed * speed
            self.found[1] += m * v[1]
            ti.atomic_min(self.found[2], ti.min(self.grid.cell_size, self.grid.cell_height(0)) / (c + speed))
            ti.atomic_min(self.found[3], e)
            if -trace((s[0], s[1], s[2], s[3])) <= 3.0 * self.law.rest_stress * (1.0 + 1e-9):
                self.found[4] += 1.0
            ti.atomic_max(self.found[6], speed)
            h, up = self.grid.cell_size, self.grid.cell_height(0)
            across = self.grid.periodic or (x[0] > -h and x[0] < (self.grid.columns - 4) * h)
            inside = across and x[1] > -up and x[1] < (self.grid.rows - 4) * up
            finite = trace((s[0], s[1], s[2], s[3])) + speed < 1e300
            if not (inside and finite):
                self.found[5] += 1.0
