"""The background grid and points that a user gives; where the size of a cell is not given, it is chosen."""

import math

from pydantic import Field, field_validator

from taichi_silo.scene import cell_sizes, fill_shape
from taichi_silo.scene.method_options import Shape
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import Options

MORE = 4  # points a cell: one does not hold an inclined wall's pressure (see `mpm.walls.surfaces`), and lets too
# little sand fall out of an outlet of few cells (`validation/beverloo.py`)
MOST_PER_CELL = 10_000
MOST_CELLS = 20_000  # across or along a silo


class Mesh(Options):
    """Background grid and points."""

    cell_size_m: float = Field(
        0.005,
        ge=1e-5,
        le=100,
        description="size of a cell of the grid; it divides the width; where a scene lacks it and the default does not "
        "fit, about 40 cells go across",
    )
    points_per_cell: int = Field(
        1,
        description="points in a cell at the start, a square number: 1, 4, 9, ...; where a scene lacks it 1, or 4 if "
        f"walls cut cells, or sand falls freely through an outlet less than {cell_sizes.WIDE_OUTLET} cells wide",
    )
    shape: Shape = Field("ugimp", description="shape functions")

    @field_validator("points_per_cell")
    @classmethod
    def _square(cls, value: int) -> int:
        if not 1 <= value <= MOST_PER_CELL or math.isqrt(value) ** 2 != value:
            raise ValueError(
                f"points per cell is {shown(value)}; it must be a square number: 1, 4, 9, 16, ... up to {MOST_PER_CELL}"
            )
        return value

    @property
    def chosen(self) -> tuple[str, ...]:
        """What follows the silo, as it was not given."""
        return tuple(name for name in ("cell_size_m", "points_per_cell") if name not in self.model_fields_set)

    def fitted(self, silo: Silo, falls: bool) -> "Mesh":
        """The grid, the size of its cells and their points chosen for a silo where they are not given.

        `falls`: whether the sand falls out of it freely.
        """
        cell = cell_sizes.chosen(silo, self.cell_size_m) if "cell_size_m" in self.chosen else self.cell_size_m
        narrow = falls and cell_sizes.narrow_outlet(silo, cell)
        fitting = {"cell_size_m": cell, "points_per_cell": MORE if silo.cuts_cells or narrow else 1}
        values = {name: fitting[name] for name in self.chosen if fitting[name] != getattr(self, name)}
        if not values:
            return self
        found = self.model_copy(update=values)
        found.__pydantic_fields_set__.difference_update(values)
        return found

    def check(self, silo: Silo) -> None:
        """Refuse cells that do not fit a silo, and name some that do."""
        h = self.cell_size_m
        if "cell_size_m" in self.chosen and (words := cell_sizes.unmet(silo)):
            raise ValueError(words)
        for name, length in (("width", silo.width_m), ("height", silo.height_m)):
            cells = length / h
            if cells > MOST_CELLS * (1.0 + 1e-6):
                raise ValueError(
                    f"cell size is {h} m; it makes {cells:.4g} cells along the {name} of {length} m, at most "
                    f"{MOST_CELLS} are allowed (lengths are in metres)"
                )
            whole = cell_sizes.whole(length, h) or name == "height" and not cell_sizes.square(silo)
            if not whole or round(cells) < 2:
                kind = "cells" if name == "height" and not cell_sizes.square(silo) else "whole cells"
                raise ValueError(
                    f"cell size is {h} m; it must divide the {name} of {length} m into at least 2 {kind}: "
                    f"{cell_sizes.remedy(silo, h)}"
                )
        narrow = cell_sizes.narrowest_m(silo)
        if narrow < 2.0 * h * (1.0 - 1e-9):
            raise ValueError(
                f"outlet width is {narrow:g} m; on cells of {h} m it must be at least {2 * h:g} m: "
                f"{cell_sizes.remedy(silo, h)}"
            )
        left, right = fill_shape.sides_m(silo)
        if right - left < 2.0 * h * (1.0 - 1e-9):
            raise ValueError(
                f"column is {right - left:g} m wide; on cells of {h} m it must be at least {2 * h:g} m: "
                f"{cell_sizes.remedy(silo, h)}"
            )
        for one in silo.openings if silo.outlets else ():
            edge = next((edge for edge in (one.low, one.high) if not cell_sizes.whole(edge, h)), None)
            if edge is not None:
                raise ValueError(
                    f"outlet width is {one.width:.12g} m; its edge at {'x' if one.in_floor else 'y'} = {edge:g} m must "
                    f"lie on the grid, whose lines are {h} m apart: {cell_sizes.remedy(silo, h)}"
                )
        edge = next((edge for edge in silo.column_m or () if not cell_sizes.whole(edge, h)), None)
        if edge is not None:
            raise ValueError(
                f"side of the column at x = {edge:g} m must lie on the grid, whose lines are {h} m apart: "
                f"{cell_sizes.remedy(silo, h)}"
            )
        if silo.section == "round" and round(silo.width_m / h) % 2:
            raise ValueError(
                f"cell size is {h} m; it must divide the radius of {0.5 * silo.width_m} m of a round silo: "
                f"{cell_sizes.remedy(silo, h)}"
            )
