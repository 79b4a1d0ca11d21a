"""A silo from a DXF drawing: its largest closed line is the inside, closed lines within are bodies."""

from pathlib import Path

import numpy as np

from taichi_silo import outline
from taichi_silo.faults import BadInput
from taichi_silo.vessel import Insert, Silo

UNITS_M = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
OF_DRAWING = {1: "in", 4: "mm", 5: "cm", 6: "m"}  # codes of the header's $INSUNITS
ARC_M = 1e-3  # largest distance of a curve from the corners that stand for it
DIGITS = 7  # of corners, in metres


def read_silo(file: Path, unit: str | None = None) -> Silo:
    """The silo of a drawing in side view.

    Its lowest side is the floor, at y = 0, and its leftmost corner is moved to x = 0.

    Parameters
    ----------
    file : DXF; lines that are not closed, and texts, are passed over.
    unit : mm, cm, m or in; that of the drawing if not given.

    Raises
    ------
    BadInput
        if it cannot be read, says no unit, or holds no closed line.
    ValidationError
        if the lines make no silo.

    """
    try:
        import ezdxf
        from ezdxf.path import make_path
    except ImportError as error:
        raise BadInput("reading drawings needs ezdxf: install taichi-silo[drawings]") from error
    try:
        drawing = ezdxf.readfile(file)
    except (OSError, UnicodeDecodeError, ezdxf.DXFError) as error:
        why = getattr(error, "strerror", None) or error
        raise BadInput(f"{file} cannot be read as a DXF drawing: {why}") from error
    unit = unit or OF_DRAWING.get(drawing.header.get("$INSUNITS", 0))
    if unit not in UNITS_M:
        raise BadInput(f"unit is {unit}; the drawing says none, so it must be given: {', '.join(UNITS_M)}")
    scale, found = UNITS_M[unit], []
    for entity in drawing.modelspace().query("LWPOLYLINE POLYLINE CIRCLE ELLIPSE SPLINE"):
        path = make_path(entity)
        if path.is_closed:
            corners = [(scale * place.x, scale * place.y) for place in path.flattening(ARC_M / scale)]
            found.append(_without_repeats(np.array(corners)))
    if not found:
        raise BadInput(f"{file} holds no closed line; the silo's inside must be a closed polyline")
    found.sort(key=lambda corners: -outline.area(corners))
    inside, bodies = found[0], found[1:]
    origin = inside.min(axis=0)
    inserts = tuple(Insert.polygon(np.round(body - origin, DIGITS)) for body in bodies)
    return Silo.polygon(np.round(inside - origin, DIGITS), inserts=inserts)


def _without_repeats(corners: np.ndarray) -> np.ndarray:
    """Corners, each but once in a row, the last not again the first."""
    apart = np.abs(corners - np.roll(corners, 1, axis=0)).max(axis=1) > outline.SAME
    return corners[apart]
