"""Bodies that touch a wall or the floor: which part of their outline meets sand, and what of the walls they cover."""

from typing import TYPE_CHECKING

import numpy as np
import shapely

if TYPE_CHECKING:
    from taichi_silo.scene.inserts import Insert
    from taichi_silo.scene.silo import Silo

NEAR = 1e-7  # a body nearer to a wall than that touches it [m]


def check(silo: "Silo", insert: "Insert") -> None:
    """Refuse a body that reaches beyond the walls, closes the silo, or stands in an outlet: a ValueError."""
    body = shapely.Polygon(insert.outline(silo.width_m))
    left, low, right, _ = body.bounds
    where = f"the {insert.kind} between x = {left:.4g} and {right:.4g} m"
    if not silo.body.buffer(NEAR).covers(body):
        raise ValueError(
            f"{where} reaches beyond a wall; it must stand free of the walls of a silo {silo.width_m} m wide, or end "
            "at one of them"
        )
    if len(_lines(_free(silo, body))) > 1:
        raise ValueError(f"{where} touches the walls in two places; sand could not pass: it must touch in one at most")
    for one in silo.openings:
        met = body.buffer(NEAR).intersection(shapely.LineString(one.ends)).length
        if met > 2.5 * NEAR:
            what = (
                "its whole floor is the outlet"
                if not silo.outlets
                else f"the outlet is from {one.low:g} to {one.high:g} m"
            )
            raise ValueError(f"{where} stands in an outlet ({what}); it must stand beside it" + (
                "" if silo.outlets or low > 0.0 else ", or above the floor at 0"))  # fmt: skip


def touches(silo: "Silo", insert: "Insert") -> bool:
    """Whether a body touches a wall or the floor."""
    return not silo.body.contains_properly(shapely.Polygon(insert.outline(silo.width_m)))


def free_outline(silo: "Silo", insert: "Insert") -> np.ndarray:
    """The part of a body's outline that meets sand (n, 2), anticlockwise [m]; all of it, closed, if it stands free."""
    outline = insert.outline(silo.width_m)
    if not touches(silo, insert):
        return np.concatenate([outline[-1:], outline])
    (line,) = _lines(_free(silo, shapely.Polygon(outline)))
    return np.array(line.coords)


def uncovered(silo: "Silo", chain: np.ndarray) -> list[np.ndarray]:
    """The parts of a line along a wall (n, 2) that no body covers, in its direction [m]."""
    found = shapely.LineString(chain)
    for insert in silo.inserts:
        if touches(silo, insert):
            found = found.difference(shapely.Polygon(insert.outline(silo.width_m)).buffer(NEAR))
    return [np.array(line.coords) for line in _lines(found)]


def _free(silo: "Silo", body: shapely.Polygon) -> shapely.Geometry:
    """The outline of a body less what lies on the silo's."""
    return body.exterior.difference(silo.body.exterior.buffer(NEAR))


def _lines(found: shapely.Geometry) -> list[shapely.LineString]:
    """The lines of a geometry, those that meet end to end made one."""
    parts = [one for one in shapely.get_parts(found) if one.length > 4.0 * NEAR]
    if len(parts) > 1:
        parts = list(shapely.get_parts(shapely.line_merge(shapely.MultiLineString(parts), directed=True)))
    return parts
