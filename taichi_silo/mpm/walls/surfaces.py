"""Walls that do not follow the grid: inclined walls of a hopper, bodies inside the sand.

To hold the nodes inside such a wall would make it as rough as the grid's steps. So the wall presses on the sand from
its true surface: stations along it, some to a cell, carry a traction (p, tau) that grows as the sand approaches and
slides, and that goes to the nodes with the weights that they have at the station,

    p += k v_n dt,  tau += k v_t dt,  |tau| <= mu p,  p >= 0 (a gap opens instead),  f_i -= (p n + tau t) S_i ds,

with weights S_i = S_i(x) a_i / sum(S a), a_i = m_i / (m_i + LIGHT M), and v = sum(S_i v_i) the velocity of the sand
there; M is the mass of a full cell. A uniform stress in the sand and its traction on the wall must leave all nodes in
equilibrium; that takes S_i(x) itself. So all nodes weigh alike, but for those with less than a tenth of a full mass,
which the traction would throw about. (With weights in proportion to m_i the sand between the wall and the middle of
its cells is held by nobody and yields like a soft layer: the lid of a hopper bears up to half as much again, and
a filter of the stresses makes sand creep.)

The stiffness k = STIFFNESS rho h / dt^2 follows from the step and does not limit it; the wall gives way like a layer
of sand of a sixth of a cell (automatic step, four points a cell). Balance is exact: what nodes get is what is booked.
The grid must stand still.
"""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from taichi_silo.mpm.field_memory import put, values
from taichi_silo.mpm.frozen import frozen
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real, whole_numbers
from taichi_silo.mpm.walls.contact import Coulomb, NoSlip

PER_CELL = 4  # stations along the edge of a cell
STIFFNESS = 1.0  # k dt^2 / (rho h): the square of the angle by which sand on the wall swings in a step
LIGHT = 0.1  # of a full cell's mass, below which a node bears less of the traction
ON_AXIS = 1e-6  # of a cell: nearer to the axis of a round silo there is no wall
SAME = 1e-6  # relative difference of shares that is round-off
LEAST = 0.02  # of the mass of a full cell: less sand around a station, and nothing touches


@frozen
class Surface:
    """A polygon line; the sand lies to the left of it, seen along its direction.

    Parameters
    ----------
    name : "hopper_left", "insert_1", ...
    corners : of the line [m], in the frame of the grid.
    contact : Coulomb, or NoSlip (very rough: sand neither slides nor parts).
    gaps : numbers of its sides that are none.
    bands : lower and upper end [m], and friction angle [degrees], of parts with Coulomb friction of their own.

    """

    name: str
    corners: tuple[tuple[float, float], ...]
    contact: Coulomb | NoSlip
    gaps: tuple[int, ...] = ()
    bands: tuple[tuple[float, float, float], ...] = ()

    def friction(self, height_m: np.ndarray) -> np.ndarray:
        """Friction coefficient at heights (n,) [m]; below 0: very rough."""
        found = np.full(len(height_m), -1.0 if isinstance(self.contact, NoSlip) else self.contact.coefficient)
        for low, high, angle_deg in self.bands:
            found[(height_m >= low) & (height_m < high)] = math.tan(math.radians(angle_deg))
        return found

    def stations(self, cell_size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Places (n, 2), unit normals out of the sand (n, 2), and lengths (n,) of its stations."""
        places, normals, lengths = [], [], []
        corners = np.array(self.corners)
        for number, (start, end) in enumerate(pairwise(corners)):
            if number in self.gaps:
                continue
            length = float(np.hypot(*(end - start)))
            count = max(1, round(PER_CELL * length / cell_size))
            along = (end - start) / length
            places.append(start + (np.arange(count)[:, None] + 0.5) / count * (end - start))
            normals.append(np.tile([along[1], -along[0]], (count, 1)))
            lengths.append(np.full(count, length / count))
        return np.concatenate(places), np.concatenate(normals), np.concatenate(lengths)


class NoSurfaces:
    """No such wall."""

    ACTIVE = False

    def clear(self) -> None:
        """Nothing to let go."""

    def take_over(self, other: object) -> None:
        """Nothing to take over."""

    def stored_J(self, step_s: float) -> float:
        """No energy."""
        return 0.0


@ti.data_oriented
class Surfaces:
    """All of them on a grid.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    traction        station, 4  pressure p, friction tau along the tangent [Pa], gap [m], 1 / sum(S a), 0 untouched
    fixed           station, 5  normal (2), area [m], friction coefficient (below 0: very rough), mass M of a full cell
    patch           station     flat index of its first node
    weight          station, 9  S of its 3 x 3 nodes
    seen            node, 3     mass and velocity of the node in the present step
    link, given     pair        station whose traction a node gets, and weight times area; `begin` (node + 1) says where
    ==============  ==========  ========================================================================

    """

    ACTIVE = True

    def __init__(
        self, surfaces: Sequence[Surface], grid: Grid, density: float, first_wall: int,
        depth: Callable[[np.ndarray], np.ndarray],
    ):  # fmt: skip
        h = grid.cell_size
        self.grid, self.density, self.first_wall = grid, density, first_wall
        places, normals, areas, friction, owner = [], [], [], [], []
        for number, surface in enumerate(surfaces):
            x, n, s = surface.stations(h)
            places.append(x)
            normals.append(n)
            areas.append(s)
            friction.append(surface.friction(x[:, 1]))
            owner.append(np.full(len(x), first_wall + number))
        place, normal, area = np.concatenate(places), np.concatenate(normals), np.concatenate(areas)
        row = np.floor(place[:, 1] / grid.first_cell_height + 1e-9).astype(int) + MARGIN
        order = np.argsort(row, kind="stable")
        # none outside the grid, and in a round silo none beyond the axis
        inside = (row[order] >= 0) & (row[order] < grid.rows) & (depth(place[order, 0]) > ON_AXIS * h)
        order = order[inside]
        place, normal, area, row = place[order], normal[order], area[order], row[order]
        mu, owners = np.concatenate(friction)[order], np.concatenate(owner)[order]
        away = depth(place[:, 0])
        self.count = len(place)
        self.places, self.normals, self.areas, self.owners = place, normal, area * away, owners
        self.fixed = ti.field(real, shape=(self.count, 5))
        full = density * h * grid.first_cell_height * np.maximum(away, 1e-12)
        put(self.fixed, np.column_stack([normal, area * away, mu, full]))
        patch, weight = self._weights(place / (h, grid.first_cell_height))
        self.patches, self.station_weights = patch, weight
        self.weight = ti.field(real, shape=(self.count, 9))
        put(self.weight, weight)
        self.traction = ti.field(real, shape=(self.count, 4))
        self.seen = ti.field(real, shape=(grid.nodes, 3))
        nodes = patch[:, None] + np.array([b * grid.columns + a for b in range(3) for a in range(3)])
        self.nodes = nodes
        given = weight * (area * away)[:, None]
        station = np.repeat(np.arange(self.count), 9)
        sort = np.argsort(nodes.ravel(), kind="stable")
        self.given = ti.field(real, shape=len(sort))
        put(self.given, given.ravel()[sort])
        whole = {
            "wall": owners,
            "patch": patch,
            "row": np.searchsorted(row, np.arange(grid.rows + 1)),
            "link": station[sort],
            "begin": np.searchsorted(nodes.ravel()[sort], np.arange(grid.nodes + 1)),
        }
        for (name, numbers), field in zip(whole.items(), whole_numbers(*map(np.shape, whole.values())), strict=True):
            setattr(self, name, field)
            put(field, numbers)

    def _weights(self, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First node (n,) and S (n, 9) of the quadratic spline at places in cells (n, 2)."""
        first = np.floor(place - 0.5).astype(int)
        along = []
        for axis in range(2):
            f = place[:, axis] - first[:, axis] - 0.5  # 0 to 1
            along.append(np.stack([0.5 * (1.0 - f) ** 2, 0.5 + f - f * f, 0.5 * f * f], axis=1))
        weight = along[1][:, :, None] * along[0][:, None, :]
        i, j = first[:, 0] + MARGIN, first[:, 1] + MARGIN
        i, j = np.clip(i, 0, self.grid.columns - 3), np.clip(j, 0, self.grid.rows - 3)
        return (j * self.grid.columns + i).astype(np.int32), weight.reshape(len(place), 9)

    def clear(self) -> None:
        """Let go."""
        put(self.traction, 0.0)
        put(self.seen, 0.0)

    def take_over(self, other: "Surfaces") -> None:
        """Press as others, of the same walls, did."""
        put(self.traction, values(other.traction))
        put(self.seen, values(other.seen))

    def restore(self, traction: np.ndarray, seen: np.ndarray) -> None:
        """Go on from a checkpoint; one of version 0.1 has shares of other weights, which are computed anew."""
        put(self.seen, seen)
        mass, full = seen[self.nodes, 0], values(self.fixed)[:, 4:]
        total = (self.station_weights * mass / (mass + LIGHT * full)).sum(axis=1)
        other = (traction[:, 3] > 0.0) & (np.abs(traction[:, 3] * total - 1.0) > SAME)
        share = np.where(other, 1.0 / np.maximum(total, 1e-300), traction[:, 3])
        put(self.traction, np.column_stack([traction[:, :3], share]))

    def stored_J(self, step_s: float) -> float:
        """Energy of these springs, (p^2 + tau^2) / 2 k over their area, for steps of so long [J/m, or per radian]."""
        p, tau, _, share = values(self.traction).T
        area, full = values(self.fixed)[:, (2, 4)].T
        mass = (self.station_weights * values(self.seen)[self.nodes, 0]).sum(axis=1)
        density = self.density * np.maximum(mass / full, LEAST)
        stiffness = STIFFNESS * density * self.grid.cell_size / step_s**2
        return float(((share > 0.0) * area * (p**2 + tau**2) / (2.0 * stiffness)).sum())

    def area_by_row(self, wall: int) -> np.ndarray:
        """Area of a wall that the nodes of each row stand for (rows,) [m2/m, or per radian]."""
        mine = self.owners == wall
        area, patch = self.areas[mine, None] * self.station_weights[mine], self.patches[mine]
        row = patch[:, None] // self.grid.columns + np.repeat(np.arange(3), 3)[None, :]
        return np.bincount(row.ravel(), area.ravel(), minlength=self.grid.rows)

    @ti.func
    def press_on(self, impulses: ti.template(), k, j, dt):
        """Force on node k of row j; what it gets in a step is booked for the wall, in that row."""
        x, y = 0.0, 0.0
        for n in range(self.begin[k], self.begin[k + 1]):
            q = self.link[n]
            s = self.given[n] * self._bears(q, self.seen[k, 0]) * self.traction[q, 3]
            p, tau, nx, ny = self.traction[q, 0], self.traction[q, 1], self.fixed[q, 0], self.fixed[q, 1]
            fx, fy = -s * (p * nx - tau * ny), -s * (p * ny + tau * nx)
            x, y = x + fx, y + fy
            impulses.add_wall(self.wall[q], j, k, (fx * dt, fy * dt))
        return x, y

    @ti.func
    def _bears(self, q, mass):
        """How much of the traction of station q a node of some mass takes, from 0 to 1."""
        return mass / (mass + LIGHT * self.fixed[q, 4])

    @ti.func
    def note(self, k, mass, x, y):
        """Mass and velocity of node k after a step."""
        self.seen[k, 0], self.seen[k, 1], self.seen[k, 2] = mass, x, y

    @ti.func
    def press_row(self, friction: ti.template(), j, dt):
        """New tractions of the stations of row j, with friction of `walls.friction`."""
        h = self.grid.cell_size
        for q in range(self.row[j], self.row[j + 1]):
            first = self.patch[q]
            m, total, vx, vy = 0.0, 0.0, 0.0, 0.0
            for b in ti.static(range(3)):
                for a in ti.static(range(3)):
                    k = first + b * self.grid.columns + a
                    weight, mass = self.weight[q, 3 * b + a], self.seen[k, 0]
                    share = weight * self._bears(q, mass)
                    m, total = m + weight * mass, total + share
                    vx, vy = vx + share * self.seen[k, 1], vy + share * self.seen[k, 2]
            nx, ny, mu = self.fixed[q, 0], self.fixed[q, 1], self.fixed[q, 3]
            filled = m / self.fixed[q, 4]
            p, tau, gap, per_share = 0.0, 0.0, self.traction[q, 2], 0.0
            if filled > LEAST:
                per_share = 1.0 / total
                vx, vy = vx * per_share, vy * per_share
                # times a velocity: what the traction grows by in a step
                stiff = STIFFNESS * filled * self.density * h / dt
                towards, along = vx * nx + vy * ny, vy * nx - vx * ny
                p = self.traction[q, 0] + stiff * towards
                tau = self.traction[q, 1] + stiff * along
                if mu >= 0.0:
                    if gap > 0.0:
                        gap -= towards * dt
                        p = ti.max(-gap, 0.0) * stiff / dt
                        gap = ti.max(gap, 0.0)
                    elif p < 0.0:
                        gap = -p * dt / stiff
                        p = 0.0
                    most = friction.of_station(q, mu * p, along, dt)
                    tau = ti.max(-most, ti.min(most, tau))
            else:
                gap = 0.0
                friction.leave_station(q)
            self.traction[q, 0], self.traction[q, 1], self.traction[q, 2] = p, tau, gap
            self.traction[q, 3] = per_share
