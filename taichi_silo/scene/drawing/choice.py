"""Which closed line of a drawing is the silo's inside, and which are bodies in it; asked where that is not plain."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from taichi_silo.errors import BadInput
from taichi_silo.scene import polygons
from taichi_silo.scene.drawing.joining import ClosedLine
from taichi_silo.utils.messages import shown

DIGITS = 7  # of corners, in metres
HAIR = 2e-4  # of a line's larger side: how far a level side may be out of level
TOP = 0.05  # of the width: least width of a level top; that of a round line's corners is narrower
SMALL = 0.01  # of the largest silo's area: a smaller rectangle beside it is part of a table or a legend
WALL = 0.5  # share of a line that another one in it fills, from which on it may be the inner face of a wall
TALL = 0.5  # share of a border's height that a silo in it has
MOST_MERGED = 300  # lines among which neighbours are looked for
MOST_NAMED = 4


class Unclear(BadInput):
    """Several closed lines could be the silo's inside.

    Attributes
    ----------
    lines : all closed lines, in the order of their numbers.

    """

    def __init__(self, sentence: str, lines: Sequence[ClosedLine]):
        super().__init__(sentence)
        self.lines = tuple(lines)


@dataclass(frozen=True)
class Chosen:
    """The inside, the closed lines in it that are bodies, and in words what was passed over."""

    number: int
    inside: ClosedLine
    bodies: tuple[ClosedLine, ...]
    words: tuple[str, ...]


def outline_of(line: ClosedLine) -> np.ndarray:
    """Corners (n, 2) of a closed line as an outline, from its leftmost and lowest place.

    Corners that lie within a hair of its outermost levels and places, or within the widest gap that was closed, are
    moved onto them. Raises ValueError if it can
    be no silo.
    """
    if not len(line.corners):
        raise ValueError("it encloses nothing")
    if line.oval:
        raise ValueError("it is a circle or an ellipse, and has no level floor")
    hair = max(HAIR * max(line.size_m), line.slack_m)
    corners = np.array(line.shape.simplify(line.slack_m).exterior.coords[:-1]) if line.slack_m else line.corners
    corners = corners - corners.min(axis=0)
    for axis in (0, 1):
        for place in (0.0, corners[:, axis].max()):
            corners[np.abs(corners[:, axis] - place) <= hair, axis] = place
    corners = polygons.without_straight(polygons.without_repeats(np.round(corners, DIGITS)))
    if len(corners) > polygons.MOST_CORNERS:
        raise ValueError(f"it has more than {polygons.MOST_CORNERS} corners; draw it with fewer")
    left, right = polygons.sides(tuple((x, y) for x, y in corners.tolist()))
    if right[-1, 0] - left[-1, 0] < TOP * line.size_m[0]:
        raise ValueError(f"its level top is narrower than {TOP:.0%} of its width; draw it up to where the fill ends")
    return corners


def possible(line: ClosedLine) -> bool:
    """Whether a closed line can be the inside of a silo."""
    try:
        outline_of(line)
    except ValueError:
        return False
    return True


def numbered(lines: list[ClosedLine], level_m: float) -> list[ClosedLine]:
    """Closed lines, the largest first; neighbours that make one silo are one, and a line that is drawn twice is one."""
    able = [possible(line) for line in lines]
    silos = [line for line, one in zip(lines, able, strict=True) if one]
    others = [line for line, one in zip(lines, able, strict=True) if not one]
    if len(silos) <= MOST_MERGED:
        silos = _merged(_once(silos), level_m)
    return sorted(silos + others, key=lambda line: -line.shape.area)


def chosen(lines: list[ClosedLine], level_m: float, number: int | None, layers_given: bool, least_m: float) -> Chosen:
    """The inside and its bodies.

    Raises Unclear if several lines could be the inside; BadInput if none could.

    Parameters
    ----------
    lines : closed lines in the order of their numbers.
    level_m : tolerance of levels.
    number : of the line that is the inside, from 1, if it is given.
    layers_given : whether the layers of bodies and inside were named.
    least_m : size below which a body is too small for a grid, over the width of the inside.

    """
    if number is None:
        number = _plain(lines, level_m, layers_given)
    elif not 1 <= number <= len(lines):
        raise BadInput(f"line is {number}; the drawing has {len(lines)} closed lines, numbered by size, from 1")
    inside = lines[number - 1]
    shape, least = inside.shape, least_m * inside.size_m[0]
    bodies: list[ClosedLine] = []
    crossed: list[ClosedLine] = []
    words, small, within, around, beside = list(inside.done), 0, 0, 0, 0
    shapely.prepare(shape)
    for one in lines:
        if one is inside:
            continue
        other = one.shape
        shared = shape.intersection(other).area
        if shared <= 1e-6 * min(shape.area, other.area):
            beside += 1
        elif shared >= (1.0 - 1e-6) * shape.area:
            around += 1
        elif max(one.size_m) < least:
            small += 1
        elif shared < (1.0 - 1e-6) * other.area:
            crossed.append(one)
        elif one.bridged:
            continue
        elif any(body.shape.covers(other) and not body.shape.equals(other) for body in bodies):
            within += 1
        else:
            bodies.append(one)
    if crossed:
        raise Unclear(
            f"line {_name(lines, crossed[0])} crosses the inside, line {_name(lines, inside)}; bodies stand free of "
            "it: choose layers with --layer",
            lines,
        )
    for count, what in (
        (around, "around it"), (beside, "beside it"), (within, "within bodies"),
        (small, f"in it smaller than {least:.3g} m"),
    ):  # fmt: skip
        if count:
            words.append(f"closed lines {what} passed over ({count})")
    return Chosen(number, inside, tuple(bodies), tuple(words))


def _plain(lines: list[ClosedLine], level_m: float, layers_given: bool) -> int:
    """Number of the line that is the inside, where that is plain."""
    silos = [line for line in lines if possible(line)]
    if not silos:
        try:
            outline_of(lines[0])
        except ValueError as error:
            which = (
                "the closed line"
                if len(lines) == 1
                else f"none of the {len(lines)} closed lines, not even the largest,"
            )
            raise Unclear(
                f"{which} {_name(lines, lines[0])} can{'not' * (len(lines) == 1)} be a silo's inside: {error}", lines
            ) from error
    silos = [line for line in silos if line.shape.area > SMALL * silos[0].shape.area]
    cores = [line.shape.buffer(-level_m) for line in silos]
    weighty = [line for number, (line, core) in enumerate(zip(silos, cores, strict=True))
               if not any(larger.shape.covers(core) for larger in silos[:number])]  # fmt: skip
    if len(weighty) > 1:
        walls = ", or draw the inside as one closed line if they are its two walls" if _two_walls(*weighty[:2]) else ""
        raise Unclear(f"{_list(lines, weighty)} could each be the silo; choose one by --line or --layer{walls}", lines)
    outermost = weighty[0]
    shape = outermost.shape
    for line in lines:
        if line is outermost or not shape.buffer(level_m).covers(line.shape):
            continue
        share = line.shape.area / shape.area
        if share >= WALL:
            raise Unclear(
                f"line {_name(lines, line)} fills {share:.0%} of line {_name(lines, outermost)}: is it the inner face "
                f"of a wall, or a silo in a border (--line {_number(lines, line)}), or a body (--line "
                f"{_number(lines, outermost)})?",
                lines,
            )
        or_layer = f" or --layer {shown(line.layer)}" if line.layer != outermost.layer else ""
        if possible(line) and _silo_in_border(line, outermost, layers_given):
            raise Unclear(
                f"line {_name(lines, outermost)} may be a border or wall around the silo, line {_name(lines, line)} "
                f"(--line {_number(lines, line)}{or_layer}), or the silo with a body in it (--line "
                f"{_number(lines, outermost)})",
                lines,
            )
    return _number(lines, outermost)


def _silo_in_border(line: ClosedLine, border: ClosedLine, layers_given: bool) -> bool:
    """Whether a line may be a silo rather than a body: tall, or in a rectangle, on its own layer, or wider above."""
    if line.bridged or line.size_m[1] > TALL * border.size_m[1]:
        return True
    if not _rectangle(border):
        return False
    other_layer = line.layer != border.layer and not layers_given
    left, right = polygons.sides(tuple((x, y) for x, y in outline_of(line).tolist()))
    widens = right[-1, 0] - left[-1, 0] > 1.01 * (right[0, 0] - left[0, 0])
    return other_layer or bool(widens)


def _two_walls(one: ClosedLine, other: ClosedLine) -> bool:
    """Whether two lines are each other's mirror image, and none its own: a wall of steel is, a silo seldom."""
    left, right = (line.corners - line.corners.min(axis=0) for line in (one, other))
    image = shapely.Polygon(left * (-1.0, 1.0) + (left[:, 0].max(), 0.0))
    alike = [image.symmetric_difference(shapely.Polygon(line)).area < 0.01 * image.area for line in (right, left)]
    return alike == [True, False]


def _rectangle(line: ClosedLine) -> bool:
    return bool(line.shape.area > 0.999 * shapely.box(*line.shape.bounds).area)


def _number(lines: Sequence[ClosedLine], line: ClosedLine) -> int:
    return next(number for number, one in enumerate(lines, 1) if one is line)


def _name(lines: Sequence[ClosedLine], line: ClosedLine) -> str:
    (wide, high), (x, y) = line.size_m, np.round(line.corners.min(axis=0), DIGITS) + 0.0
    return f"{_number(lines, line)} (layer {shown(line.layer, 30)}, {wide:.4g} m x {high:.4g} m at {x:.4g}, {y:.4g} m)"


def _list(lines: Sequence[ClosedLine], some: Sequence[ClosedLine]) -> str:
    names = [_name(lines, one) for one in some[:MOST_NAMED]]
    more = f" and {len(some) - MOST_NAMED} more" if len(some) > MOST_NAMED else ""
    return f"lines {', '.join(names)}{more}"


# --- neighbours that make one silo ------------------------------------------------------------------------------------


def _once(lines: list[ClosedLine]) -> list[ClosedLine]:
    found: list[ClosedLine] = []
    for line in lines:
        if not any(line.shape.symmetric_difference(one.shape).area < 1e-6 * one.shape.area for one in found):
            found.append(line)
    return found


def _merged(lines: list[ClosedLine], level_m: float) -> list[ClosedLine]:
    """Lines, of which those that stand on each other, and two mirrored halves, are one."""
    waiting, done = list(lines), []
    while waiting:
        one = waiting.pop(0)
        for other in waiting:
            word = _neighbours(one, other, level_m)
            if word and possible(whole := _union(one, other, word, level_m)):
                waiting = [line for line in waiting if line is not other] + [whole]
                break
        else:
            done.append(one)
    return done


def _union(one: ClosedLine, other: ClosedLine, word: str, level_m: float) -> ClosedLine:
    whole = shapely.union(one.shape, shapely.snap(other.shape, one.shape, level_m), grid_size=0.1**DIGITS)
    layers = ", ".join(sorted({*one.layer.split(", "), *other.layer.split(", ")}))
    corners = np.array(whole.exterior.coords[:-1]) if isinstance(whole, shapely.Polygon) else one.corners[:0]
    return ClosedLine(
        layers,
        corners,
        tuple(dict.fromkeys((*one.done, *other.done, word))),
        one.bridged or other.bridged,
        slack_m=max(one.slack_m, other.slack_m),
    )


def _neighbours(one: ClosedLine, other: ClosedLine, level_m: float) -> str:
    """How two lines make one silo, in words; empty if they do not."""
    low, high = sorted((one, other), key=lambda line: line.corners[:, 1].min())
    if abs(low.corners[:, 1].max() - high.corners[:, 1].min()) <= level_m:
        top = low.corners[low.corners[:, 1] > low.corners[:, 1].max() - level_m - 1e-12, 0]
        floor = high.corners[high.corners[:, 1] < high.corners[:, 1].min() + level_m + 1e-12, 0]
        shared = min(top.max(), floor.max()) - max(top.min(), floor.min())
        if shared > 0.99 * min(np.ptp(top), np.ptp(floor)):
            return "parts that stand on each other were joined"
    left, right = sorted((one, other), key=lambda line: line.corners[:, 0].min())
    axis = right.corners[:, 0].min()
    if abs(left.corners[:, 0].max() - axis) <= level_m and not _rectangle(one):  # two boxes may be two silos
        mirrored = shapely.Polygon(left.corners * (-1.0, 1.0) + (2.0 * axis, 0.0))
        seam = left.shape.buffer(level_m).intersection(right.shape.buffer(level_m)).bounds
        whole = seam and seam[3] - seam[1] > 0.99 * left.size_m[1]
        if whole and mirrored.symmetric_difference(right.shape).area < 0.01 * right.shape.area:
            return "two mirrored halves were joined"
    return ""
