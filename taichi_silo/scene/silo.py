"""The silo that a user gives: walls, outlet, hopper, inserts, and which of its places hold sand.

Coordinates are those of the laboratory: x from the left wall, y from the floor (of a hopper: from its outlet), upwards.
A round silo is described by its section through the axis, which stands at half the width.
"""

import math
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import shapely
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from taichi_silo.scene import fill_shape, polygons, silo_checks
from taichi_silo.scene.inserts import Insert
from taichi_silo.scene.outlets import OneOrSeveral, Opening, Outlet
from taichi_silo.utils.schema import Options

MOST_INSERTS = 50
POINTS_AT_ONCE = 500_000  # of a lattice
__all__ = ["Hopper", "Insert", "Outlet", "Silo"]


class Hopper(Options):
    """Walls that converge towards an outlet, which is as wide as their lower ends are apart."""

    half_angle_deg: float = Field(ge=0.1, lt=80, description="half angle of the walls, from the vertical")
    outlet_width_m: float = Field(ge=1e-4, le=1000, description="width of the opening between their lower ends")
    friction_angle_deg: float | None = Field(
        None, ge=0, lt=90, description="of the hopper's walls; that of the side walls if absent"
    )


class Silo(Options):
    """Two parallel walls, or a round one, with what closes it below; forces are per metre run (of the wall's girth)."""

    width_m: float = Field(0.2, ge=0.001, le=1000, description="width between the walls, or diameter of a round silo")
    height_m: float = Field(0.5, ge=0.001, le=1000, description="height of the fill above the floor, a hopper included")
    section: Literal["plane", "round"] = Field(
        "plane", description="between parallel walls, or a cylinder about the middle; a hopper is a wedge, or a cone"
    )
    half: Literal["auto", "yes", "no"] = Field("auto", description="compute one half of a symmetric silo and mirror it")
    outlet: OneOrSeveral | None = None
    hopper: Hopper | None = None
    outline_m: polygons.Corners | None = Field(
        None,
        max_length=polygons.MOST_CORNERS,
        description="corners (x, y) of the space for sand, instead of a hopper: a polygon with a level floor at y = 0, "
        "the outlet unless there is one in it, a level top, and sides that lead up; width and height are its own if "
        "absent",
    )
    inserts: tuple[Insert, ...] = Field((), max_length=MOST_INSERTS)
    column_m: tuple[float, float] | None = Field(
        None,
        description="x of the left and right side of the fill, which stands free of at least one wall: smooth walls "
        "hold it there until a collapse takes them away at once",
    )
    surface_m: polygons.Corners | None = Field(
        None,
        max_length=polygons.MOST_CORNERS,
        description="corners (x, y) of the surface of the fill from left to right, a heap or a slope, level beyond its "
        "ends; the height is that of its top if absent",
    )

    @model_validator(mode="before")
    @classmethod
    def _sized(cls, given):
        """Width and height of an outline, and height of a surface, where they are not given."""
        if not isinstance(given, dict):
            return given
        for name, sizes in (("surface_m", ("height_m",)), ("outline_m", ("height_m", "width_m"))):
            if given.get(name):
                try:
                    x, y = np.array([tuple(map(float, corner)) for corner in given[name]]).T
                except (TypeError, ValueError, OverflowError):
                    return given  # what is wrong with it is said by the type
                if x.max() > 0.0 and y.max() > 0.0:
                    size = {"height_m": float(y.max()), "width_m": float(x.max())}
                    given = {one: size[one] for one in sizes} | given
        return given

    @classmethod
    def polygon(cls, outline_m: Iterable[Sequence[float]], **more: Any) -> "Silo":
        """A silo of any shape: corners (x, y) [m] of the space for sand, and other values (outlet, ...)."""
        return cls(outline_m=tuple((float(x), float(y)) for x, y in outline_m), **more)

    @model_validator(mode="after")
    def _fits(self):
        silo_checks.check(self)
        return self

    # --- what follows from it -------------------------------------------------------------------------------------

    @property
    def floor_is_outlet(self) -> bool:
        """Whether the whole floor is the outlet, and the grid sinks with it."""
        closed = self.outlet is None and self.hopper is None and self.outline_m is None and not self.inserts
        return closed and self.column_m is None

    @property
    def has_opening(self) -> bool:
        """Whether there is an opening in what closes it below, through which sand leaves it."""
        return not self.floor_is_outlet and self.column_m is None

    @property
    def sides(self) -> tuple[np.ndarray, np.ndarray]:
        """Left and right side, each (n, 2) from the floor up to the fill's surface or beyond [m]."""
        return _sides(self)

    @property
    def feet_m(self) -> tuple[float, float]:
        """Heights from which on the sides stand at x = 0 and at the width: 0 without hopper or outline."""
        left, right = self.sides
        return polygons.foot(left, 0.0), polygons.foot(right, self.width_m)

    @property
    def floor_m(self) -> tuple[float, float]:
        """Left and right end of the floor, or of the opening between the lower ends of inclined walls."""
        left, right = self.sides
        return float(left[0, 0]), float(right[0, 0])

    @property
    def body(self) -> shapely.Polygon:
        """Space inside the silo."""
        left, right = self.sides
        return shapely.Polygon(np.concatenate([right, left[::-1]]))

    @property
    def outlets(self) -> tuple[Outlet, ...]:
        """The outlets that are given."""
        return self.outlet if isinstance(self.outlet, tuple) else () if self.outlet is None else (self.outlet,)

    @property
    def openings(self) -> tuple[Opening, ...]:
        """Where sand leaves: the outlets that are given, or the whole floor."""
        first, last = self.floor_m
        if not self.outlets:
            return (Opening("floor", first, last),)
        return tuple(self._opening(outlet, first, last) for outlet in self.outlets)

    def _opening(self, outlet: Outlet, first: float, last: float) -> Opening:
        """What an outlet opens in a floor between two places, or in a wall."""
        b, position, times = outlet.width_m, outlet.position, (outlet.opens_at_s, outlet.closes_at_s)
        at = self.width_m if outlet.wall == "right" else 0.0
        if isinstance(position, float):
            return Opening(outlet.wall, position - 0.5 * b, position + 0.5 * b, at, *times)
        left = {"centre": 0.5 * (first + last - b), "left": first, "right": last - b}[position]
        return Opening(outlet.wall, left, left + b, at, *times)

    @property
    def one_opening(self) -> bool:
        """Whether sand leaves by one opening in the floor, from the begin of the outflow to its end."""
        only, *more = self.openings
        return only.in_floor and not more and not any(outlet.timed for outlet in self.outlets)

    @property
    def outlet_m(self) -> tuple[float, float]:
        """X of the left and right edge of the opening in the floor [m]; of several the outermost."""
        floor = [one for one in self.openings if one.in_floor] or [Opening("floor", *self.floor_m)]
        return min(one.low for one in floor), max(one.high for one in floor)

    @property
    def outlet_share_m(self) -> float:
        """Area of all outlets as `area_m2` counts: their widths, in a round silo d^2 / (4 R)."""
        width = sum(one.width for one in self.openings)
        return width**2 / (2.0 * self.width_m) if self.section == "round" else width

    @property
    def sinking_share(self) -> float:
        """Part of the silo's section below which sand leaves through the floor."""
        share = sum(one.width for one in self.openings if one.in_floor) / self.width_m
        return share**2 if self.section == "round" else share

    @property
    def eccentricity_m(self) -> float:
        """Distance of the middle of an outlet from the axis, the greatest of several [m]."""
        middles = [0.5 * (one.low + one.high) if one.in_floor else one.at_m for one in self.openings]
        return max(abs(middle - 0.5 * self.width_m) for middle in middles)

    @property
    def transition_m(self) -> float:
        """Height at which a hopper, or the last inclined wall of an outline, meets the vertical walls; 0 without."""
        if self.hopper is None:
            return 0.0 if self.outline_m is None else max(self.feet_m)
        tangent = math.tan(math.radians(self.hopper.half_angle_deg))
        return 0.5 * (self.width_m - self.hopper.outlet_width_m) / tangent

    @property
    def straight_m(self) -> float:
        """Height of sand between vertical walls on both sides, to the level of a surface over as much sand.

        0 where inclined walls lead up to the surface, and for a column, which walls of its own hold.
        """
        if self.column_m is not None or fill_shape.lowest_m(self) - self.transition_m <= polygons.SAME:
            return 0.0
        return fill_shape.level_m(self) - self.transition_m

    @property
    def one_sided(self) -> bool:
        """Whether one wall stands vertical farther down than the other."""
        left, right = self.feet_m
        return abs(left - right) > polygons.SAME

    def between(self, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """X of the left and of the right wall [m] at heights y (array) [m]."""
        left, right = self.sides
        return polygons.place(left, y), polygons.place(right, y)

    def holds(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Whether points x, y (arrays) [m] lie in the fill."""
        left, right = self.between(y)
        inside = (x > left) & (x < right) & (y > 0.0) & (y < self.height_m)
        if self.column_m is not None:
            inside = inside & (x > self.column_m[0]) & (x < self.column_m[1])
        if self.surface_m is not None:
            inside = inside & (y < fill_shape.top_m(self, x))
        for insert in self.inserts:
            inside = inside & ~insert.contains(x, y, self.width_m)
        return inside

    @property
    def cuts_cells(self) -> bool:
        """Whether walls or bodies cross the cells of the grid."""
        return self.hopper is not None or self.outline_m is not None or bool(self.inserts)

    def lattice(self, spacing_m: float, rise_m: float | None = None) -> tuple[np.ndarray, ...]:
        """x, y [m] and area [m2] of the points that fill it, row after row from the floor, each a rise above the other.

        Without a rise points are as far apart along y as along x.
        Rows fit between the walls: in a hopper points stand a little closer or farther apart than elsewhere.
        """
        rise_m = spacing_m if rise_m is None else rise_m
        count = round(self.height_m / rise_m)
        at_once = max(1, int(POINTS_AT_ONCE * spacing_m / self.width_m))
        parts = [self._rows(np.arange(first, min(first + at_once, count)), spacing_m, rise_m)
                 for first in range(0, count, at_once)]  # fmt: skip
        return tuple(np.concatenate(values) for values in zip(*parts, strict=True))

    def _rows(self, numbers: np.ndarray, spacing_m: float, rise_m: float) -> tuple[np.ndarray, ...]:
        """The points of rows of these numbers."""
        y = (numbers + 0.5) * rise_m
        left, right = self.between(y)
        pairs = 2 if self.section == "round" else 1  # the axis stands between two points
        counts = np.maximum(1, np.round((right - left) / (pairs * spacing_m)).astype(int)) * pairs
        wide, area = (np.repeat(values, counts) for values in (right - left, rise_m * (right - left) / counts))
        number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        x, y = np.repeat(left, counts) + (number + 0.5) * wide / np.repeat(counts, counts), np.repeat(y, counts)
        held = self.holds(x, y)
        return x[held], y[held], area[held]

    def points(self, spacing_m: float, rise_m: float | None = None) -> int:
        """Number of points of `lattice`."""
        return _count(self, spacing_m, rise_m)

    @property
    def box_m2(self) -> float:
        """Area of a box of its width and height [m2], counted as `area_m2` counts."""
        return self.width_m * self.height_m * (0.5 if self.section == "round" else 1.0)

    @property
    def area_m2(self) -> float:
        """Area of the section of the fill [m2]; of a round silo twice its volume per radian over its radius."""
        if self.section == "round":
            return fill_shape.area_between_m2(self, 0.0, self.height_m)
        below = fill_shape.region(self)
        return float(self.body.intersection(below).area) - sum(insert.area_m2() for insert in self.inserts)

    def solids(self) -> list[np.ndarray]:
        """Outlines (n, 2) of hopper walls and inserts, for pictures [m]."""
        found = [insert.outline(self.width_m) for insert in self.inserts]
        for side, wall in zip(self.sides, (0.0, self.width_m), strict=True):
            foot = polygons.foot(side, wall)
            chain = side[side[:, 1] <= foot + polygons.SAME]
            if foot > 0.0:
                found.append(np.concatenate([[[wall, 0.0]], chain, [[wall, foot]]]))
        return found

    def words(self) -> str:
        """Section, outlet, hopper and inserts, as titles of figures name them; empty for a plane silo without these."""
        found = []
        if self.section == "round":
            found.append("round silo")
        found += [outlet.words() for outlet in self.outlets]
        if self.hopper is not None:
            found += [
                f"hopper of {self.hopper.half_angle_deg:g}°",
                f"outlet of {1e3 * self.hopper.outlet_width_m:g} mm",
            ]
        if self.outline_m is not None:
            found.append(f"silo of {len(self.outline_m)} corners")
        found += [insert.words() for insert in self.inserts]
        if self.column_m is not None:
            found.append(f"column of {1e3 * (self.column_m[1] - self.column_m[0]):g} mm")
        if self.surface_m is not None:
            found.append("fill with a surface of its own")
        return ", ".join(found)


@lru_cache(maxsize=64)
def _sides(silo: Silo) -> tuple[np.ndarray, np.ndarray]:
    if silo.outline_m is not None:
        return polygons.sides(silo.outline_m)
    wide, high, foot = silo.width_m, silo.height_m, silo.transition_m
    if silo.hopper is None:
        return np.array([[0.0, 0.0], [0.0, high]]), np.array([[wide, 0.0], [wide, high]])
    left = 0.5 * (wide - silo.hopper.outlet_width_m)
    return np.array([[left, 0.0], [0.0, foot], [0.0, high]]), np.array([[wide - left, 0.0], [wide, foot], [wide, high]])


@lru_cache(maxsize=64)
def _count(silo: Silo, spacing_m: float, rise_m: float | None) -> int:
    return len(silo.lattice(spacing_m, rise_m)[0])
