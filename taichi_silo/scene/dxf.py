"""A silo from a DXF drawing in side view: one closed line is its inside, closed lines within are bodies."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.scene.drawing import choice, entities, file, grid, joining, units
from taichi_silo.scene.silo import MOST_INSERTS, Insert, Silo
from taichi_silo.utils.messages import shown


@dataclass(frozen=True)
class Drawn:
    """What was taken from a drawing.

    Attributes
    ----------
    silo : with the grid's cell size that fits it.
    cell_size_m : of square cells.
    lines : all closed lines, in the order of their numbers, in the drawing's place [m].
    number : of the one that is the inside, from 1.
    bodies : numbers of those that are bodies.
    words : what was taken, and what was passed over, a sentence each.

    """

    silo: Silo
    cell_size_m: float
    lines: tuple[joining.ClosedLine, ...]
    number: int
    bodies: tuple[int, ...]
    words: tuple[str, ...]

    def tables(self) -> dict:
        """The tables of a scene file."""
        silo = self.silo.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
        return {"silo": silo, "grid": {"cell_size_m": self.cell_size_m}}


def read_silo(
    file: Path,
    unit: str | None = None,
    layers: Iterable[str] = (),
    line: int | None = None,
    gap_m: float | None = None,
) -> Silo:
    """The silo of a drawing, as `read_drawing` takes it."""
    return read_drawing(file, unit, layers, line, gap_m).silo


def read_drawing(
    path: Path,
    unit: str | None = None,
    layers: Iterable[str] = (),
    line: int | None = None,
    gap_m: float | None = None,
) -> Drawn:
    """The silo of a drawing in side view, and what was taken for it.

    Its lowest side is the floor, at y = 0, and its leftmost corner is moved to x = 0.

    Raises BadInput if it cannot be read, says no unit, or holds no closed line that can be a silo; `choice.Unclear`, a
    BadInput that carries the lines, if several can be; ValidationError if the lines make no silo.

    Parameters
    ----------
    path : DXF; texts, dimensions and layers that are off, frozen or not printed are passed over.
    unit : mm, cm, m, in, ft, ...; that of the drawing if not given.
    layers : whose lines count, hidden or not; all that show if none are given.
    line : number of the closed line that is the inside, by size from 1; the one that is plain if not given.
    gap_m : ends at most so far apart are joined [m]; 1/500 of the drawing's larger side if not given.

    """
    layers = tuple(layers)
    if gap_m is not None and not 0.0 <= gap_m <= 1.0:
        raise BadInput(f"gap is {gap_m} m; it must be between 0 and 1 m")
    if unit is not None:
        unit = units.of_name(unit)
    drawing, mended = file.opened(path)
    found = entities.lines_of(drawing, layers)
    if not found.lines:
        raise BadInput(f"{path} holds no closed line: {_elsewhere(drawing, found)}")
    axes = entities.in_plane(found.lines)
    control = np.concatenate([one.control for one in found.lines])[:, axes]
    wide, high = map(float, np.ptp(control, axis=0))
    unit, known = units.of_drawing(drawing.header, unit, (wide, high))
    scale = units.units()[unit]
    if not units.possible(scale * max(wide, high)):
        raise BadInput(f"unit is {unit}, {known}; {units.doubts(drawing.header, unit, scale * wide, scale * high)}")
    pieces = _pieces(found.lines, axes, scale)
    if not pieces:
        raise BadInput(f"{path} holds no closed line: its lines have no length")
    level = joining.GAP * joining.extent_of(pieces) if gap_m is None else gap_m
    lines, unused = _closed_lines(path, pieces, gap_m, level)
    taken = choice.chosen(lines, level, line, bool(layers), grid.LEAST)
    outline = choice.outline_of(taken.inside)
    doubt = units.doubts(drawing.header, unit, *map(float, outline.max(axis=0)))
    if doubt and known != "as given" and not units.plausible(*outline.max(axis=0)):
        raise BadInput(f"unit is {unit}, {known}; {doubt}")
    if len(taken.bodies) > MOST_INSERTS:
        raise BadInput(
            f"{path} holds {len(taken.bodies)} closed lines in the silo; it has at most {MOST_INSERTS} inserts, so "
            "choose layers with --layer"
        )
    origin = taken.inside.corners.min(axis=0)
    inserts = tuple(Insert.polygon(np.round(body.corners - origin, choice.DIGITS)) for body in taken.bodies)
    silo = Silo.polygon(outline, inserts=inserts)
    silo, cell, of_grid = grid.fitted(silo)
    words = [_taken(taken, len(lines), silo, outline, unit, known), *taken.words]
    words += [f"open lines passed over ({unused})"] if unused else []
    words += [doubt] if doubt else []
    words += ["The drawing's file is damaged: what could be read was taken"] if mended else []
    words += [
        "The drawing stands upright in space: its side view is the plane of " + " and ".join("xyz"[k] for k in axes)
    ] * (axes != (0, 1))
    if found.hidden:
        words.append(
            f"layers that are off, frozen or not printed passed over: {shown(', '.join(sorted(found.hidden)), 120)}"
        )
    numbers = tuple(next(k for k, one in enumerate(lines, 1) if one is body) for body in taken.bodies)
    words = [f"{one[:1].upper()}{one[1:]}." for one in (*words, of_grid)]
    return Drawn(silo, cell, tuple(lines), taken.number, numbers, tuple(words))


def _pieces(lines: list[entities.Line], axes: tuple[int, int], scale: float) -> list[joining.Piece]:
    found = []
    for one in lines:
        corners = entities.corners_of(one, axes, scale)
        if len(corners) > 1 and np.ptp(corners, axis=0).max() > 0.0:
            found.append(joining.Piece(one.layer, corners, bool(one.path.is_closed), one.oval))
    return found


def _closed_lines(
    path: Path, pieces: list[joining.Piece], gap_m: float | None, level_m: float
) -> tuple[list[joining.ClosedLine], int]:
    """Closed lines in the order of their numbers: of lines that meet at their ends, else of lines that cross.

    Behind them the number of lines that belong to none.

    Raises BadInput if there is none.
    """
    joined = joining.joined(pieces, gap_m)
    lines = choice.numbered(joined.closed, level_m)
    silos = [one for one in lines if choice.possible(one)]
    if all(one.bridged for one in silos):  # a drawn lid goes before one that is put in
        crossing = choice.numbered(joining.crossing(pieces, gap_m), level_m)
        large = max((one.shape.area for one in crossing if choice.possible(one)), default=0.0)
        if large > 0.5 * max((one.shape.area for one in silos), default=0.0):
            return crossing, 0
    if not lines:
        raise BadInput(f"{path} holds no closed line: {_open(joined)}")
    return lines, len(joined.unused)


def _open(joined: joining.Joined) -> str:
    """What keeps lines from being closed."""
    if joined.gap is None:
        return "the silo's inside must be one, or lines that meet"
    apart, x, y = joined.gap
    return (
        f"its lines end apart ({len(joined.unused)}), the nearest ends {apart:.4g} m from each other at x = {x:.4g}, "
        f"y = {y:.4g} m; draw what is missing"
        + (f", or join them with --gap {1.01 * apart:.3g}" if apart < 0.05 * joined.extent_m else "")
    )


def _elsewhere(drawing: Any, found: entities.Found) -> str:
    """Where the lines are, if not in sight in the model space."""
    papers = [layout.name for layout in drawing.layouts if layout.name != "Model" and _holds_lines(layout)]
    if found.hidden:
        names = sorted(found.hidden)
        return (
            f"its lines are on layers that are off, frozen or not printed; --layer {shown(names[0])} takes one anyway"
        )
    if papers:
        return (
            f"its lines are in the paper space ({shown(', '.join(papers), 100)}); move them to the model space (in "
            "CAD: CHSPACE), where a silo is drawn in its size"
        )
    if found.others:
        return f"it holds {shown(', '.join(f'{count} {kind}' for kind, count in found.others.most_common(5)), 120)}"
    return "it is empty"


def _holds_lines(layout: Any) -> bool:
    return any(entity.dxftype() in (*entities.KINDS, *entities.CONTAINERS) for entity in layout)


def _taken(taken: choice.Chosen, count: int, silo: Silo, outline: np.ndarray, unit: str, known: str) -> str:
    left, right = silo.floor_m
    wide, high = outline.max(axis=0)
    bodies = f"{len(taken.bodies)} bodies" if len(taken.bodies) != 1 else "1 body"
    return (
        f"Taken: closed line {taken.number} of {count}, layer {shown(taken.inside.layer)}: {wide:.6g} m wide, "
        f"{high:.6g} m high, floor from x = {left:.6g} to {right:.6g} m, {bodies}; unit {unit}, {known}"
    )
