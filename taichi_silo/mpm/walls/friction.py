"""How soon the friction of a wall follows its normal force.

Coulomb's law that follows at once makes a sliding elastic body flutter: waves of opening and slip run along its base,
feed on the weight that slides, and let it creep where friction would hold it (Martins, Guimaraes and Faria 1995 for a
block, Adams 1995 for a half space). Friction that follows within a time t*, as measured under jumps of the normal force
(Prakash and Clifton 1993), takes that away:

    dF/dt = (mu N - F) (1 / t* + |v_t| / h),    friction <= F

With t* the time in which a wave crosses the body three times, none of its modes is fed. The mean of F is that of mu N;
a contact younger than t* remembers all of it alike. Where sand has slipped by a cell h, the node stands at other sand
than it remembers, hence the second term. Friction outlasts a contact by t*, so this is for what slides, not for what
rebounds.
"""

import math

import numpy as np

from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import real

CROSSINGS = 3.0  # of a body by a wave in t*: fewer hold less, more lag behind where it slides

SLOWEST = 1e-6  # wave [m/s]: sand without stiffness has none


class AtOnce:
    """Friction that follows the normal force at once."""

    ACTIVE = False

    @ti.func
    def of_station(self, q, most, sliding, dt):
        """Largest shear stress of station q of a surface [Pa], mu p being `most`."""
        return most

    @ti.func
    def leave(self, k):
        """Node k has no sand."""

    @ti.func
    def leave_station(self, q):
        """Station q has no sand."""


@ti.data_oriented
class Delayed:
    """Friction that follows the normal force within a time.

    ==============  =============  ===========================================================================
    field           shape          meaning
    ==============  =============  ===========================================================================
    nodal           wall, node, 2  F on a node of a grid line's wall [N/m]; how long it has had sand [s]
    stations        station, 2     F per area of a surface that does not follow the grid [Pa]; the same time
    time            1              t* [s]
    ==============  =============  ===========================================================================

    Parameters
    ----------
    particles, grid : of the solver.
    walls, stations : how many there are.
    delay_s : t*; None: from the speed of waves (see `know_waves`) and the lesser side of a rectangle with the
        points' moments of inertia.

    """

    ACTIVE = True

    def __init__(self, particles: Particles, grid: Grid, walls: int, stations: int, delay_s: float | None):
        self.grid, self.walls = grid, walls
        self.nodal = ti.field(real, shape=(max(walls, 1), grid.nodes, 2))
        self.stations = ti.field(real, shape=(max(stations, 1), 2))
        self.time = ti.field(real, shape=1)
        self.crossed = 0.0  # way of a wave in t* [m]; 0 if t* is given
        if delay_s is None:
            place = particles.array("position")
            least = float(np.linalg.eigvalsh(np.cov(place.T, bias=True))[0]) if len(place) > 1 else 0.0
            self.crossed = CROSSINGS * max(math.sqrt(12.0 * max(least, 0.0)), grid.cell_size)
        else:
            self.time[0] = delay_s

    def know_waves(self, speed_m_per_s: float) -> None:
        """Waves in the sand have this speed."""
        if self.crossed:
            self.time[0] = self.crossed / max(speed_m_per_s, SLOWEST)

    @ti.func
    def after(self, before, age, most, sliding, dt):
        """F after a step, where contact has this age [s] and mu N is `most`."""
        share = ti.min(1.0, dt / ti.min(self.time[0], age + dt) + ti.abs(sliding) * dt / self.grid.cell_size)
        return before + share * (most - before)

    @ti.func
    def of_node(self, wall: ti.template(), k, most, sliding, dt):
        """Largest impulse of friction of a wall on node k in a step [N s/m], mu times the normal one being `most`."""
        before, age = self.nodal[wall, k, 0], self.nodal[wall, k, 1]
        now = self.after(before, age, most / dt, sliding, dt)
        self.nodal[wall, k, 0], self.nodal[wall, k, 1] = now, age + dt
        return dt * now

    @ti.func
    def of_station(self, q, most, sliding, dt):
        """Largest shear stress of station q of a surface [Pa], mu p being `most`."""
        before, age = self.stations[q, 0], self.stations[q, 1]
        now = self.after(before, age, most, sliding, dt)
        self.stations[q, 0], self.stations[q, 1] = now, age + dt
        return now

    @ti.func
    def leave(self, k):
        """Node k has no sand: it forgets."""
        for wall in ti.static(range(self.walls)):
            self.nodal[wall, k, 1] = 0.0

    @ti.func
    def leave_station(self, q):
        """Station q has no sand: it forgets."""
        self.stations[q, 1] = 0.0
