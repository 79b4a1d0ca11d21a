"""Where in a silo the sand stands: from wall to wall under a level top, or as a column, a heap or a slope.

A surface is a line of corners (x, y) from left to right; beyond its ends it is level.
"""

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import ArrayLike

from taichi_silo.scene import polygons

if TYPE_CHECKING:
    from taichi_silo.scene.silo import Silo

ALIKE = 1e-9  # of a place, by which the two sides of a round silo may differ [m]


def sides_m(silo: "Silo") -> tuple[float, float]:
    """X of the left and the right side of the fill [m]."""
    return (0.0, silo.width_m) if silo.column_m is None else silo.column_m


def top_m(silo: "Silo", x: ArrayLike) -> np.ndarray:
    """Height of the surface of the fill at places x (array) [m]."""
    x = np.asarray(x, float)
    if silo.surface_m is None:
        return np.full(x.shape, silo.height_m)
    corners = np.array(silo.surface_m)
    return np.interp(x, corners[:, 0], corners[:, 1])


def lowest_m(silo: "Silo") -> float:
    """Height of the lowest place of the surface between the sides of the fill [m]."""
    left, right = sides_m(silo)
    inner = [] if silo.surface_m is None else [x for x, _ in silo.surface_m if left < x < right]
    return float(top_m(silo, np.array([left, *inner, right])).min())


def region(silo: "Silo") -> shapely.Polygon:
    """What is below the surface and between the sides of the fill, floor included."""
    left, right = sides_m(silo)
    inner = [] if silo.surface_m is None else [tuple(corner) for corner in silo.surface_m if left < corner[0] < right]
    ends = [(x, float(top_m(silo, x))) for x in (left, right)]
    return shapely.Polygon([(left, 0.0), (right, 0.0), ends[1], *inner[::-1], ends[0]])


@lru_cache(maxsize=256)
def area_between_m2(silo: "Silo", low_m: float, high_m: float, cells: int = 1000) -> float:
    """Area of the section of the fill between two heights [m2], as `Silo.area_m2` counts; if round, by a fine sum."""
    if silo.section == "round":
        radius = 0.5 * silo.width_m
        x = (np.arange(cells) + 0.5) / cells * radius
        y = (np.arange(2 * cells) + 0.5) / (2 * cells) * silo.height_m
        x, y = np.meshgrid(x, y)
        held = silo.holds(radius + x, y) & (y >= low_m) & (y < high_m)
        return float(2.0 / radius * (x * held).mean() * radius * silo.height_m)
    fill = silo.body.intersection(region(silo))
    for insert in silo.inserts:
        fill = fill.difference(shapely.Polygon(insert.outline(silo.width_m)))
    return float(fill.intersection(shapely.box(0.0, low_m, silo.width_m, high_m)).area)


def level_m(silo: "Silo") -> float:
    """Height of a level surface over as much sand, EN 1991-4's equivalent surface [m].

    The sides of the fill are vertical where the surface is.
    """
    if silo.surface_m is None:
        return silo.height_m
    left, right = sides_m(silo)
    x = left + (np.arange(2000) + 0.5) / 2000 * (right - left)
    weights = np.abs(x - 0.5 * silo.width_m) if silo.section == "round" else np.ones_like(x)
    return float(np.average(top_m(silo, x), weights=weights))


def free_walls(silo: "Silo") -> tuple[bool, bool]:
    """Whether the left and the right side of the fill are walls that a collapse takes away."""
    if silo.column_m is None:
        return False, False
    left, right = silo.column_m
    return left > polygons.SAME, right < silo.width_m - polygons.SAME


def symmetric(silo: "Silo") -> bool:
    """Whether sides and surface of the fill are alike about the middle of the silo."""
    left, right = sides_m(silo)
    if abs(left + right - silo.width_m) > ALIKE:
        return False
    places = np.array([0.0, silo.width_m] if silo.surface_m is None else [x for x, _ in silo.surface_m])
    places = np.concatenate([places, silo.width_m - places])
    return bool(np.allclose(top_m(silo, places), top_m(silo, silo.width_m - places), rtol=0.0, atol=ALIKE))


def check(silo: "Silo") -> None:
    """Refuse a column or a surface that does not fit the silo: a ValueError in a sentence."""
    if silo.column_m is not None:
        _check_column(silo, silo.column_m)
    if silo.surface_m is not None:
        _check_surface(silo, silo.surface_m)
    if silo.section == "round" and not symmetric(silo):
        raise ValueError("column and surface of a round silo must be symmetric about its axis at half the width")


def _check_column(silo: "Silo", column_m: tuple[float, float]) -> None:
    left, right = column_m
    if not 0.0 <= left < right <= silo.width_m:
        raise ValueError(
            f"column is {left:g} to {right:g} m; its sides must be in order, between 0 and the width of "
            f"{silo.width_m:g} m"
        )
    if not any(free_walls(silo)):
        raise ValueError(
            f"column is {left:g} to {right:g} m, the whole width; one side at least must leave free width beside it"
        )
    parts = {"an outlet": silo.outlet, "a hopper": silo.hopper, "an outline": silo.outline_m, "inserts": silo.inserts}
    if beside := [name for name, part in parts.items() if part]:
        raise ValueError(f"a silo with a column has {beside[0]}; a column stands on a closed level floor without any")


def _check_surface(silo: "Silo", surface_m: polygons.Corners) -> None:
    x, y = np.array(surface_m, float).T
    if len(x) < 2 or not (np.diff(x) > 0.0).all():
        raise ValueError(f"surface has {len(x)} corners; it needs two or more, x rising from one to the next")
    if x[0] < -polygons.SAME or x[-1] > silo.width_m + polygons.SAME:
        raise ValueError(
            f"surface reaches from x = {x[0]:g} to {x[-1]:g} m; it must be between 0 and the width of "
            f"{silo.width_m:g} m"
        )
    if y.min() < 0.0:
        raise ValueError(f"surface has a corner at y = {y.min():g} m; it must be 0 or more, above the floor")
    if abs(y.max() - silo.height_m) > polygons.SAME:
        raise ValueError(f"height is {silo.height_m:g} m; the surface's highest corner is at {y.max():g} m")
    for number, insert in enumerate(silo.inserts, 1):
        out = _above(silo, surface_m).intersection(shapely.Polygon(insert.outline(silo.width_m)))
        if not out.is_empty:
            corners = shapely.get_coordinates(out)
            x, top = corners[np.argmax(corners[:, 1])]
            raise ValueError(
                f"insert {number}, the {insert.kind}, stands out of the sand: at x = {x:.4g} m it reaches up to "
                f"{top:.4g} m, the surface to {float(np.interp(x, *np.array(surface_m).T)):.4g} m; it must be covered"
            )


def _above(silo: "Silo", surface_m: polygons.Corners) -> shapely.Polygon:
    """What is above the surface, up to twice the height, and beyond the walls."""
    wide, high = silo.width_m, silo.height_m
    ends = (-wide, surface_m[0][1]), (2.0 * wide, surface_m[-1][1])
    return shapely.Polygon([ends[0], *surface_m, ends[1], (2.0 * wide, 2.0 * high), (-wide, 2.0 * high)])
