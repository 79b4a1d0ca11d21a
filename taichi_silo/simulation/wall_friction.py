"""Friction along the side walls where it changes: bands stand still in the laboratory, the grid may sink."""

from collections.abc import Sequence

import numpy as np

from taichi_silo.mpm.contracts import Wall
from taichi_silo.mpm.frozen import replaced
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.walls import Bands, PlaneWall, Surface
from taichi_silo.scene import bands
from taichi_silo.scene.scene import Walls


def banded(sides: tuple[PlaneWall, ...], walls: Walls, grid: Grid) -> tuple[PlaneWall, ...]:
    """The left and the right wall with bands, where the silo's walls have some; an axis has none."""
    if not walls.bands:
        return sides
    found = tuple(
        replaced(side, bands=Bands(max(grid.columns, grid.rows))) if side.name != "axis" else side for side in sides
    )
    place(found, walls, grid, 0.0)
    return found


def place(sides: Sequence[Wall], walls: Walls, grid: Grid, origin_m: float) -> None:
    """Tell walls with bands where these are, the grid's origin standing at a height [m]."""
    h = grid.first_cell_height
    for side in sides:
        if isinstance(side, PlaneWall) and side.bands is not None:
            height = (np.arange(max(grid.columns, grid.rows)) - MARGIN) * h + origin_m
            side.bands.set(bands.coefficient(walls, side.name, height - 0.5 * h, height + 0.5 * h))


def of_surface(surface: Surface, wall: str, walls: Walls) -> Surface:
    """An inclined wall with the bands of the "left" or "right" one."""
    found = tuple(
        (band.from_m or -np.inf, band.top_m, band.friction_angle_deg) for band in walls.bands if band.on(wall)
    )
    return replaced(surface, bands=found) if found else surface
