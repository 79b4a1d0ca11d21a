"""Walls, floor and inserts of a silo as lines, for programs that show them beside the sand."""

import numpy as np

from taichi_silo.scene.scene import Scene

LEFT, RIGHT, FLOOR, FIRST_INSERT = 0, 1, 2, 3  # numbers of the walls


def wall_lines(scene: Scene, displacement_m: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners (n, 2) [m], pairs of corners (m, 2) that lines join, and the number of the wall (m,) of each line.

    Walls are 0 left, 1 right, 2 bottom or floor, from 3 on inserts. Where the whole bottom sinks it does so by the
    displacement, and the side walls reach down to it.
    """
    silo = scene.silo
    sunk = displacement_m if silo.floor_is_outlet else 0.0
    chains = [(LEFT, silo.sides[0]), (RIGHT, silo.sides[1])]
    if sunk:
        chains = [(wall, np.concatenate([[[side[0, 0], -sunk]], side])) for wall, side in chains]
    first, last = silo.floor_m
    if silo.floor_is_outlet:
        chains.append((FLOOR, np.array([[first, -sunk], [last, -sunk]])))
    else:
        ends = ((first, silo.outlet_m[0]), (silo.outlet_m[1], last))
        chains += [(FLOOR, np.array([[a, 0.0], [b, 0.0]])) for a, b in ends if b > a]
    for number, insert in enumerate(silo.inserts):
        around = insert.outline(silo.width_m)
        chains.append((FIRST_INSERT + number, np.concatenate([around, around[:1]])))
    corners = np.concatenate([chain for _, chain in chains])
    starts = np.cumsum([0] + [len(chain) for _, chain in chains])
    lines = [np.arange(begin, begin + len(chain) - 1) for begin, (_, chain) in zip(starts, chains, strict=False)]
    walls = [np.full(len(chain) - 1, wall, np.int32) for wall, chain in chains]
    begins = np.concatenate(lines)
    return corners, np.column_stack([begins, begins + 1]), np.concatenate(walls)
