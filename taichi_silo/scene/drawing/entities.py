"""The lines of a drawing: which of its entities count, layer by layer, blocks taken apart, in the plane of the view."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.utils.messages import near, shown

KINDS = ("LINE", "ARC", "LWPOLYLINE", "POLYLINE", "CIRCLE", "ELLIPSE", "SPLINE")
OVAL = ("CIRCLE", "ELLIPSE")
CONTAINERS = ("INSERT", "MLINE")
MOST_LINES = 20_000
MOST_CORNERS = 20_000  # of one line
DEEPEST = 16  # blocks in blocks
PLACES = 32  # along each piece of a spline whose knots need them
NEVER = "defpoints"  # a layer that is not printed
ARC_M = 1e-3  # largest distance of a curve from the corners that stand for it
ARC = 0.005  # the same over the size of the curve
AXIS = re.compile(  # in the name of a linetype or layer of centre lines, in the languages of CAD programs
    r"cent(er|re)|mitte|strichpunkt|dash\w*dot|chain|iso(04|08|10)w|symmetr|achs"
    r"|(?<![a-z])(ax[ei]s?|cl|eixo|eje|asse)(?![a-z])",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Line:
    """A line of a drawing: its layer, and its path in the drawing's unit and space."""

    layer: str
    path: Any
    oval: bool = False  # a circle or an ellipse
    centre: bool = False  # drawn as a centre line, by its linetype or its layer's name

    @property
    def control(self) -> np.ndarray:
        """Places (n, 3) that span it."""
        return np.array([tuple(place) for place in self.path.control_vertices()])


@dataclass
class Found:
    """What a drawing holds: lines that count, and how many that do not: of other kinds, hidden, or in other files."""

    lines: list[Line]
    hidden: Counter
    others: Counter
    elsewhere: Counter  # blocks, by name, whose lines are in another file
    invisible: int = 0


def lines_of(drawing: Any, layers: Iterable[str] = ()) -> Found:
    """The lines of a drawing's model space; those of some layers only, if any are given.

    Raises BadInput if a layer is not there, or there are too many lines.
    """
    shown_layers = {_folded(name) for name in layers}
    hidden = set() if shown_layers else _hidden(drawing)
    found = Found([], Counter(), Counter(), Counter())
    names: dict[str, str] = {}
    linetypes = {_folded(one.dxf.name): one.dxf.get("linetype", "") for one in drawing.layers}
    for entity, layer in _entities(drawing.modelspace(), hidden, found):
        kind = entity.dxftype()
        names.setdefault(_folded(layer), layer)
        if shown_layers and _folded(layer) not in shown_layers:
            continue
        if _passed_over(entity, layer, hidden, found):
            continue
        centre = _centre(entity, layer, linetypes)
        line = Line(layer, _path(entity), kind in OVAL, centre) if kind in KINDS else None
        if line is None or line.path is None:
            found.others[kind] += 1
            continue
        found.lines.append(line)
        if len(found.lines) > MOST_LINES:
            raise BadInput(f"the drawing has more than {MOST_LINES} lines; choose a layer with --layer")
    for name in layers:
        if _folded(name) not in names:
            meant = near(_folded(name), names)
            raise BadInput(
                f"layer is {shown(name)}; the drawing has lines on {shown(', '.join(sorted(names.values())), 200)}"
                + (f"; did you mean {shown(names[meant])}?" if meant else "")
            )
    return found


def in_plane(lines: list[Line]) -> tuple[int, int]:
    """The two axes of the view: x and y, or x and z, or y and z of a drawing that stands upright in space.

    Raises BadInput if the lines lie in no such plane.
    """
    spans = np.array([np.ptp(line.control, axis=0) for line in lines])
    small = 1e-6 * max(float(spans.max()), 1e-300)
    for across, axes in ((2, (0, 1)), (1, (0, 2)), (0, (1, 2))):
        if (spans[:, across] <= small).all():
            return axes
    raise BadInput(
        "the drawing's lines lie in space, not in one plane; draw the side view in the plane of x and y, or of x and "
        "z, or choose its layer with --layer"
    )


def corners_of(line: Line, axes: tuple[int, int], scale: float) -> np.ndarray:
    """Corners (n, 2) of a line in its plane [m]; a closed one ends where it begins."""
    size = float(np.ptp(line.control, axis=0).max())
    if size <= 0.0:
        return np.zeros((0, 2))
    places = islice(line.path.flattening(min(ARC_M / scale, ARC * size)), MOST_CORNERS)
    return scale * np.array([tuple(place) for place in places])[:, axes]


def _entities(space: Any, hidden: set[str], found: Found, layer: str = "", deep: int = 0) -> Iterator[tuple]:
    """Entities of a layout or block with their layers; those of layer 0 in a block lie on the block's."""
    for entity in space:
        own = entity.dxf.get("layer", "0")
        own = layer if layer and own == "0" else own
        if entity.dxftype() not in CONTAINERS:
            yield entity, own
            continue
        if _passed_over(entity, own, hidden, found):
            continue
        if _elsewhere(entity):
            found.elsewhere[entity.dxf.name] += 1
        elif deep < DEEPEST:
            yield from _entities(_parts(entity), hidden, found, own, deep + 1)


def _passed_over(entity: Any, layer: str, hidden: set[str], found: Found) -> bool:
    """Whether an entity does not show, which is counted."""
    if _folded(layer) in hidden:
        found.hidden[layer] += 1
        return True
    if entity.dxf.get("invisible", 0):
        found.invisible += 1
        return True
    return False


def _elsewhere(entity: Any) -> bool:
    """Whether a block's lines are not in this file."""
    if entity.dxftype() != "INSERT":
        return False
    block = entity.block()
    return block is None or (not len(block) and (block.block.is_xref or block.block.is_xref_overlay))


def _parts(entity: Any) -> Iterator:
    """Entities that a block or multiline stands for; none of a damaged one."""
    from ezdxf import DXFError

    try:
        several = entity.dxftype() == "INSERT" and entity.mcount > 1
        for one in entity.multi_insert() if several else [entity]:
            yield from one.virtual_entities()
    except (DXFError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        return


def _path(entity: Any) -> Any:
    """The path of an entity; None if it is damaged, or no line."""
    from ezdxf import DXFError
    from ezdxf.path import from_vertices, make_path

    try:
        curve = entity.construction_tool() if entity.dxftype() == "SPLINE" else None
        path = make_path(entity) if curve is None or curve.is_clamped else from_vertices(_places(curve))
        places = np.array([tuple(place) for place in path.control_vertices()])
        return path if len(places) > 1 and np.isfinite(places).all() else None
    except (DXFError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        return None


def _places(curve: Any) -> Iterator:
    """Places along a spline that does not begin and end at its outermost knots, as a closed one may be stored."""
    knots, last = curve.knots(), len(curve.control_points)
    count = PLACES * (last - curve.degree) + 1
    return curve.points(np.linspace(knots[curve.degree], knots[last], count))


def _hidden(drawing: Any) -> set[str]:
    """Layers that are off, frozen, or not printed."""
    hidden = (one for one in drawing.layers if one.is_off() or one.is_frozen() or not one.dxf.get("plot", 1))
    return {NEVER} | {_folded(one.dxf.name) for one in hidden}


def _centre(entity: Any, layer: str, linetypes: dict[str, str]) -> bool:
    """Whether an entity is drawn as a centre line; `linetypes` are those of the layers."""
    linetype = entity.dxf.get("linetype", "BYLAYER")
    drawn_as = linetypes.get(_folded(layer), "") if linetype.upper() == "BYLAYER" else linetype
    return bool(AXIS.search(f"{drawn_as} {layer}"))


def _folded(name: str) -> str:
    return name.strip().casefold()
