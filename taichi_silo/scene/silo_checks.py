"""Whether the parts of a silo fit each other: outline, outlet, hopper, inserts, and the symmetry of a round one."""

from typing import TYPE_CHECKING

import numpy as np
import shapely

from taichi_silo.scene import fill_shape, polygons, touching
from taichi_silo.scene.inserts import Insert
from taichi_silo.scene.outlets import Opening, Outlet

if TYPE_CHECKING:
    from taichi_silo.scene.silo import Silo

ALIKE = 1e-6  # of its area, by which the mirror image of a body may differ
MILLIMETRES = 30.0  # a body so many times as high as the fill is likely given in them


def check(silo: "Silo") -> None:
    """Refuse a silo whose parts do not fit each other: a ValueError in a sentence."""
    wide = silo.width_m
    if silo.outline_m is not None:
        _check_outline(silo, silo.outline_m)
    if silo.outlet is not None and silo.hopper is not None:
        raise ValueError("a silo has an outlet in its floor or a hopper, not both: a hopper ends in its own outlet")
    if silo.outlet == ():
        raise ValueError("silo.outlet has no entries; without outlets it must be left out, and the floor is the outlet")
    for number, outlet in enumerate(silo.outlets):
        _check_outlet(silo, outlet, silo.openings[number])
    _check_outlets_apart(silo)
    if silo.hopper is not None:
        if not silo.hopper.outlet_width_m < wide:
            raise ValueError(
                f"outlet width of the hopper is {silo.hopper.outlet_width_m} m; it must be below the silo's width "
                f"of {wide} m"
            )
        if not silo.transition_m < silo.height_m:
            raise ValueError(
                f"half angle of the hopper is {silo.hopper.half_angle_deg} deg; it makes the hopper "
                f"{silo.transition_m:.4g} m high, which must be below the fill's height of {silo.height_m} m"
            )
    for insert in silo.inserts:
        _check_insert(silo, insert)
    shapes = [shapely.Polygon(insert.outline(wide)) for insert in silo.inserts]
    for number, one in enumerate(shapes):
        for before, other in enumerate(shapes[:number]):
            if one.intersects(other):
                x, y = one.intersection(other).representative_point().coords[0]
                raise ValueError(
                    f"inserts {before + 1} and {number + 1} meet at ({x:.4g}, {y:.4g}) m; they must stand apart"
                )
    if silo.section == "round":
        _check_round(silo)
    fill_shape.check(silo)


def _check_outline(silo: "Silo", outline_m: polygons.Corners) -> None:
    if silo.hopper is not None:
        raise ValueError("a silo has an outline or a hopper, not both: an outline has the hopper's walls in it")
    left, right = polygons.sides(outline_m)
    wide, high = max(left[:, 0].max(), right[:, 0].max()), left[-1, 1]
    if abs(wide - silo.width_m) > polygons.SAME:
        raise ValueError(f"width is {silo.width_m} m; that of the outline is {wide:g} m")
    if silo.height_m > high + polygons.SAME:
        raise ValueError(f"height is {silo.height_m} m; the outline ends at {high:g} m, and the fill not above it")
    mirrored = np.column_stack([silo.width_m - left[:, 0], left[:, 1]])
    if silo.section == "round" and not (len(left) == len(right) and np.allclose(mirrored, right, atol=1e-9)):
        raise ValueError("the outline of a round silo must be symmetric about its axis")


def _check_outlet(silo: "Silo", outlet: Outlet, opening: Opening) -> None:
    first, last = silo.floor_m
    b, left, right = outlet.width_m, opening.low, opening.high
    if not opening.in_floor:
        _check_side_outlet(silo, opening)
        return
    if not b < last - first:
        width = "the silo's width" if silo.outline_m is None else "the floor's width"
        raise ValueError(f"outlet width is {b} m; it must be below {width} of {last - first:g} m")
    if left < first - polygons.SAME or right > last + polygons.SAME:
        raise ValueError(
            f"outlet position is {outlet.position} m; in a floor from {first:g} to {last:g} m the middle of "
            f"{b} m must be between {first + 0.5 * b:g} and {last - 0.5 * b:g} m"
        )


def _check_side_outlet(silo: "Silo", opening: Opening) -> None:
    """Refuse an opening that is not in the vertical part of its wall, below the surface there."""
    foot, top = silo.feet_m[("left", "right").index(opening.wall)], float(fill_shape.top_m(silo, opening.at_m))
    if opening.low < foot - polygons.SAME or opening.high > top - polygons.SAME:
        raise ValueError(
            f"outlet of the {opening.wall} wall reaches from {opening.low:g} to {opening.high:g} m; it must lie in its "
            f"vertical part, between {foot:g} m and the surface of the fill at {top:g} m"
        )


def _check_outlets_apart(silo: "Silo") -> None:
    """Refuse outlets that overlap, or have nothing between them."""
    if silo.section == "round" and not silo.one_opening:
        raise ValueError(
            f"silo has {' and '.join(one.words() for one in silo.outlets)}; a round silo, computed by its section, "
            "must have a single outlet, in the middle of its floor, that opens with the outflow"
        )
    found = silo.openings
    for number, one in enumerate(found):
        for before in range(number):
            other = found[before]
            if one.wall == other.wall and one.low < other.high + polygons.SAME and other.low < one.high + polygons.SAME:
                raise ValueError(
                    f"outlet {number + 1} from {one.low:g} to {one.high:g} m meets outlet {before + 1} from "
                    f"{other.low:g} to {other.high:g} m; outlets of one wall must stand apart"
                )


def _check_insert(silo: "Silo", insert: Insert) -> None:
    outline = insert.outline(silo.width_m)
    low = outline[:, 1].min()
    if low < -polygons.SAME:
        raise ValueError(f"the {insert.kind} reaches down to {low:g} m; it must not reach below the floor at 0")
    if outline[:, 1].max() >= silo.height_m:
        high = outline[:, 1].max()
        unit = "; are its lengths in mm?" if high > MILLIMETRES * silo.height_m else ""
        raise ValueError(
            f"the {insert.kind} reaches up to {high:.4g} m; it must be below the surface of the fill at "
            f"{silo.height_m} m{unit}"
        )
    touching.check(silo, insert)


def _check_round(silo: "Silo") -> None:
    if silo.outlets and silo.outlets[0].position != "centre":
        raise ValueError(
            f"outlet position is {silo.outlets[0].position}; in a round silo, computed by its section, it must be "
            "centre"
        )
    wide = silo.width_m
    for insert in silo.inserts:
        middle = insert.centre_m(wide)
        if any(_mirrored(insert, other, wide) for other in silo.inserts):
            continue
        if abs(middle - 0.5 * wide) < polygons.SAME:
            raise ValueError(
                f"the {insert.kind} at x = {middle:g} m is not symmetric about the axis of the round silo, which is at "
                f"{0.5 * wide:g} m"
            )
        raise ValueError(
            f"position of the {insert.kind} is {middle:g} m; in a round silo it must be the axis at {0.5 * wide:g} m, "
            f"or its mirror image must stand at {wide - middle:g} m, so that both are a ring"
        )


def _mirrored(insert: Insert, other: Insert, wide_m: float) -> bool:
    """Whether one body is the mirror image of another, or of itself, about the axis."""
    image = shapely.Polygon(insert.outline(wide_m) * (-1.0, 1.0) + (wide_m, 0.0))
    differs = image.symmetric_difference(shapely.Polygon(other.outline(wide_m))).area
    return bool(differs < ALIKE * image.area) and insert.friction_angle_deg == other.friction_angle_deg
