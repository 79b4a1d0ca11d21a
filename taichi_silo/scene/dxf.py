"""A silo from a DXF drawing: its largest closed line is the inside, closed lines within are bodies."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.scene import polygons
from taichi_silo.scene.silo import MOST_INSERTS, Insert, Silo
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import shown

UNITS_M = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
OF_DRAWING = {1: "in", 4: "mm", 5: "cm", 6: "m"}  # codes of the header's $INSUNITS
ARC_M = 1e-3  # largest distance of a curve from the corners that stand for it
LARGEST = 50_000_000  # bytes of a file
DIGITS = 7  # of corners, in metres


def read_silo(file: Path, unit: str | None = None) -> Silo:
    """The silo of a drawing in side view.

    Its lowest side is the floor, at y = 0, and its leftmost corner is moved to x = 0.

    Raises BadInput if it cannot be read, says no unit, or holds no closed line; ValidationError if the lines make no
    silo.

    Parameters
    ----------
    file : DXF; lines that are not closed, and texts, are passed over.
    unit : mm, cm, m or in; that of the drawing if not given.

    """
    try:
        import ezdxf
        from ezdxf.path import make_path
    except ImportError as error:
        raise BadInput("reading drawings needs ezdxf: install taichi-silo[drawings]") from error
    bounded_reading.content(file, "a DXF drawing", LARGEST)
    try:
        drawing = ezdxf.readfile(file)
    except Exception as error:  # noqa: BLE001 - a damaged file makes its readers say anything
        raise BadInput(f"{file} cannot be read as a DXF drawing: it is none, or damaged") from error
    unit = unit or OF_DRAWING.get(drawing.header.get("$INSUNITS", 0))
    if unit not in UNITS_M:
        raise BadInput(f"unit is {shown(unit)}; the drawing says none, so it must be given: {', '.join(UNITS_M)}")
    scale, found = UNITS_M[unit], []
    for entity in drawing.modelspace().query("LWPOLYLINE POLYLINE CIRCLE ELLIPSE SPLINE"):
        corners = _corners(entity, make_path, scale)
        if len(corners) > polygons.MOST_CORNERS:
            raise BadInput(f"{file} has a line of more than {polygons.MOST_CORNERS} corners; draw it with fewer")
        if len(corners) > 2:
            found.append(corners)
    if len(found) > MOST_INSERTS + 1:
        raise BadInput(f"{file} holds {len(found)} closed lines; a silo has at most {MOST_INSERTS} inserts")
    if not found:
        raise BadInput(f"{file} holds no closed line; the silo's inside must be a closed polyline")
    found.sort(key=lambda corners: -polygons.area(corners))
    inside, bodies = found[0], found[1:]
    origin = inside.min(axis=0)
    inserts = tuple(Insert.polygon(np.round(body - origin, DIGITS)) for body in bodies)
    return Silo.polygon(np.round(inside - origin, DIGITS), inserts=inserts)


def _corners(entity: Any, make_path: Callable[[Any], Any], scale: float) -> np.ndarray:
    """Corners (n, 2) of a closed line [m], at most one more than allowed; none if it is not closed or damaged."""
    try:
        path = make_path(entity)
        if not path.is_closed or not np.isfinite([tuple(place) for place in path.control_vertices()]).all():
            return np.zeros((0, 2))
        places = itertools.islice(path.flattening(ARC_M / scale), polygons.MOST_CORNERS + 2)
        return polygons.without_repeats(np.array([(scale * place.x, scale * place.y) for place in places]))
    except (ArithmeticError, LookupError, TypeError, ValueError):  # of an entity that is none
        return np.zeros((0, 2))
