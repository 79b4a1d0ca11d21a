"""The gates of several outlets, of a side wall, or that open and close each at its time."""

import numpy as np

from taichi_silo.mpm.contracts import Wall
from taichi_silo.mpm.frozen import replaced
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.walls import Coulomb, Edges, Gate, Gates, OpenFloor, PlaneWall, SideEdges, SideGate
from taichi_silo.scene.outlets import Opening

HALF = 0.5  # of the gate's speed, that of its edges


def gated(
    sides: tuple[PlaneWall, ...], openings: tuple[Opening, ...], grid: Grid, plate: Coulomb, controlled: bool
) -> tuple[tuple[Wall, ...], Gates]:
    """Side walls with openings in them; a floor with openings; edges and gate of each; and what moves the gates.

    All openings lie in the frame of the grid. A gate is as rough as the floor, `plate`; one in a side wall that lets
    the sand out at a speed carries what has passed it.
    """
    gates, floor = Gates(len(openings)), grid.node_along(0.0)
    found: list[Wall] = []
    edges = [_edges(one, grid) for one in openings]
    walls = {"left": sides[0], "right": sides[1]}
    for name, wall in walls.items():
        own = tuple(nodes for nodes, one in zip(edges, openings, strict=True) if one.wall == name)
        walls[name] = replaced(wall, openings=own)
    in_floor = [nodes for nodes, one in zip(edges, openings, strict=True) if one.in_floor]
    if in_floor:
        (first, last), *others = in_floor
        found.append(OpenFloor(floor, first, last, plate, others=tuple(others)))
    else:
        found.append(PlaneWall("floor", 1, -1, floor, plate))
    for number, (one, (first, last)) in enumerate(zip(openings, edges, strict=True)):
        names = f"edges_{number + 1}", f"gate_{number + 1}"
        if one.in_floor:
            found.append(Edges(floor, first, last, plate, names[0], (0.0, HALF), number, gates))
            found.append(Gate(floor, first, last, plate, names[1], (0.0, 1.0), number, gates))
        else:
            side, node = -1 if one.wall == "left" else 1, walls[one.wall].node
            half, whole = (-side * HALF, 0.0), (-float(side), 0.0)  # the plate velocity is negative
            found.append(SideEdges(node, side, first, last, plate, names[0], half, number, gates))
            found.append(SideGate(node, side, first, last, plate, names[1], whole, number, gates, controlled))
    return (walls["left"], walls["right"], *found), gates


def _edges(one: Opening, grid: Grid) -> tuple[int, int]:
    """Nodes along the wall at the edges of an opening; beyond the grid where another wall bounds it."""
    first, last = grid.node_along(one.low), grid.node_along(one.high)
    beyond = grid.columns if one.in_floor else grid.rows
    width = grid.columns - 1 - MARGIN if one.in_floor else beyond
    return -1 if first <= MARGIN else first, beyond if last >= width else last


def shares(openings: tuple[Opening, ...], since_s: float, start_s: float) -> tuple[float, ...]:
    """Speed of each gate over that of one that is open, at a time after the outflow has begun.

    A gate takes `start_s` to reach its speed, or to stop, smoothly; with 0 it is open or closed.
    """

    def risen(after: float) -> float:
        part = float(after >= 0.0) if start_s == 0.0 else min(max(after / start_s, 0.0), 1.0)
        return part * part * (3.0 - 2.0 * part)

    return tuple(
        (risen(since_s - one.opens_s) if one.opens_s else 1.0)
        * (1.0 - (0.0 if one.closes_s is None else risen(since_s - one.closes_s)))
        for one in openings
    )


def next_change(openings: tuple[Opening, ...], since_s: float) -> float:
    """When, after the outflow has begun, the next gate opens or closes [s]; inf if none does."""
    times = [time for one in openings for time in (one.opens_s, one.closes_s) if time is not None and time > since_s]
    return min(times, default=np.inf)


def last_opening(openings: tuple[Opening, ...], since_s: float) -> float:
    """When, after the outflow has begun, a gate has last opened [s]."""
    return max((one.opens_s for one in openings if one.opens_s <= since_s), default=0.0)


def more_to_open(openings: tuple[Opening, ...], since_s: float) -> bool:
    """Whether a gate is still to open."""
    return any(one.opens_s > since_s for one in openings)


def forces(openings: tuple[Opening, ...], impulse: np.ndarray, first: int, duration_s: float) -> tuple[float, ...]:
    """Force of the sand on each gate and its edges [N/m], from the impulses of the solver's walls, from `first` on."""
    total = impulse.sum(axis=1) / duration_s
    pairs = (total[first + 2 * k] + total[first + 2 * k + 1] for k in range(len(openings)))
    return tuple(float(-(force @ one.outwards)) for one, force in zip(openings, pairs, strict=True))
