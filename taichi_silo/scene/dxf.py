"""A silo from a DXF drawing in side view: one closed line is its inside, closed lines within are bodies."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.scene.drawing import choice, dxf_file, entities, grid, half, joining, units, words
from taichi_silo.scene.silo import MOST_INSERTS, Insert, Silo

LARGER = 1.2  # over the silo of lines that meet closely, from which on one with wider gaps is meant


@dataclass(frozen=True)
class Drawn:
    """What was taken from a drawing.

    Attributes
    ----------
    silo : the silo.
    cell_size_m : size of cells that fit it.
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
    gap_m : ends at most so far apart are joined [m]; 1/500 of the drawing's larger side if not given, or three times
        as much where that alone makes a silo.

    """
    layers = tuple(layers)
    if gap_m is not None and not 0.0 <= gap_m <= 1.0:
        raise BadInput(f"gap is {gap_m} m; it must be between 0 and 1 m")
    given, unit = unit is not None, unit and units.of_name(unit)
    drawing, mended = dxf_file.opened(path)
    found = entities.lines_of(drawing, layers)
    if not found.lines:
        raise BadInput(f"{path} holds no closed line: {words.of_none(drawing, found)}")
    axes = entities.in_plane(found.lines)
    span = np.ptp(np.concatenate([one.control for one in found.lines])[:, axes], axis=0)
    unit, known = units.of_drawing(drawing.header, unit, (float(span[0]), float(span[1])))
    scale = units.units()[unit]
    if not units.possible(scale * float(span.max())):
        raise BadInput(f"unit is {unit}, {known}; {units.too_large_or_small(unit, *map(float, scale * span))}")
    pieces = _pieces(found.lines, axes, scale)
    if not pieces:
        raise BadInput(f"{path} holds no closed line: its lines have no length")
    level = joining.GAP * joining.extent_of(pieces) if gap_m is None else gap_m
    lines, unused = _closed_lines(path, pieces, gap_m, level)
    taken = choice.chosen(lines, level, line, bool(layers), grid.LEAST)
    silo = _silo(path, taken)
    doubt, plausible = "", units.plausible(silo.width_m, silo.height_m)
    if not (given and plausible):
        doubt = units.doubts(drawing.header, unit, silo.width_m, silo.height_m)
    if not (given or plausible):
        raise BadInput(f"unit is {unit}, {known}; {doubt}")
    head = words.of_taken(taken, len(lines), silo, unit, known)
    outline = choice.outline_of(taken.inside)
    of_shape = half.words_of(outline, taken.inside.corners.min(axis=0), pieces, level) + words.of_upside_down(outline)
    cell, of_grid = grid.fitted(silo)
    of_rest = words.of_rest(found, unused, axes, mended)
    said = [head, *of_shape, *taken.words, *of_rest, *([doubt] if doubt else []), of_grid]
    bodies = tuple(number for number, one in enumerate(lines, 1) if any(one is body for body in taken.bodies))
    return Drawn(silo, cell, tuple(lines), taken.number, bodies, tuple(f"{one[:1].upper()}{one[1:]}." for one in said))


def _silo(path: Path, taken: choice.Chosen) -> Silo:
    if len(taken.bodies) > MOST_INSERTS:
        raise BadInput(
            f"{path} holds {len(taken.bodies)} closed lines in the silo; it has at most {MOST_INSERTS} inserts, so "
            "choose layers with --layer"
        )
    origin = taken.inside.corners.min(axis=0)
    inserts = tuple(Insert.polygon(np.round(body.corners - origin, choice.DIGITS)) for body in taken.bodies)
    return Silo.polygon(choice.outline_of(taken.inside), inserts=inserts)


def _pieces(lines: list[entities.Line], axes: tuple[int, int], scale: float) -> list[joining.Piece]:
    found = []
    for one in lines:
        corners = entities.corners_of(one, axes, scale)
        if len(corners) > 1 and np.ptp(corners, axis=0).max() > 0.0:
            found.append(joining.Piece(one.layer, corners, bool(one.path.is_closed), one.oval, one.centre))
    return found


def _closed_lines(
    path: Path, pieces: list[joining.Piece], gap_m: float | None, level_m: float
) -> tuple[list[joining.ClosedLine], int]:
    """Closed lines in the order of their numbers: of lines that meet at their ends, else of lines that cross.

    Behind them the number of lines that belong to none. Where ends that meet within a gap make no silo, a wider one is
    tried, unless it is given. Raises BadInput if there is none.
    """
    joined = joining.joined(pieces, gap_m)
    lines, drawn = _numbered(joined, pieces, gap_m, level_m)
    if not drawn and gap_m is None:
        again = joining.joined(pieces, joining.WIDE * joined.extent_m)
        wider = choice.numbered(again.closed, level_m)
        if _largest(wider) > LARGER * _largest(lines):
            return wider, len(again.unused)
    if not lines:
        walls = [piece for piece in pieces if not piece.centre]
        if 0 < len(walls) < len(pieces):  # a centre line between two walls is no third one
            return _closed_lines(path, walls, gap_m, level_m)
        raise BadInput(f"{path} holds no closed line: {words.of_open(joined)}")
    return lines, 0 if drawn == "crossing" else len(joined.unused)


def _numbered(
    joined: joining.Joined, pieces: list[joining.Piece], gap_m: float | None, level_m: float
) -> tuple[list[joining.ClosedLine], str]:
    """Closed lines in the order of their numbers, and how a silo among them was drawn: "closed", "crossing", or not."""
    lines = choice.numbered(joined.closed, level_m)
    if any(choice.possible(one) and not one.bridged for one in lines):
        return lines, "closed"
    crossing = choice.numbered(joining.crossing(pieces, gap_m), level_m)  # a drawn lid goes before one that is put in
    if _largest(crossing) > 0.5 * _largest(lines):
        return crossing, "crossing"
    return lines, ""


def _largest(lines: list[joining.ClosedLine]) -> float:
    """Area of the largest line that can be a silo [m2]; 0 without."""
    return max((one.shape.area for one in lines if choice.possible(one)), default=0.0)
