"""Closed lines of a drawing: those drawn closed, and lines, arcs and open polylines that meet within a tolerance."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from taichi_silo.scene import polygons

GAP = 0.002  # of the larger side of a drawing: ends that are closer belong together,
WIDE = 0.006  # and such ends too, where that alone makes a silo
TALL = 0.25  # of the highest line: lower ones are not taken for walls
THICK = 0.5  # of the inside's width, at most: a wall of two lines
EXACT = 1e-6  # of the same: places that are closer are one


@dataclass(frozen=True)
class Piece:
    """A line of a drawing: its layer and corners (n, 2) [m]."""

    layer: str
    corners: np.ndarray
    closed: bool
    oval: bool = False  # a circle or an ellipse
    centre: bool = False  # drawn as a centre line


@dataclass(frozen=True)
class ClosedLine:
    """A closed line: its layers, its corners (n, 2) [m], the first not again the last, and how it was closed."""

    layer: str
    corners: np.ndarray
    done: tuple[str, ...] = ()
    bridged: bool = False  # a lid or floor was put in
    oval: bool = False  # a circle or an ellipse
    slack_m: float = 0.0  # widest gap that was closed in it

    @cached_property
    def shape(self) -> shapely.Polygon:
        """The area that it encloses."""
        shape = shapely.Polygon(self.corners)
        if shape.is_valid:
            return shape
        parts = shapely.get_parts(shape.buffer(0.0))  # sides that cross by a hair at a corner cut off a loop
        return max(parts, key=lambda part: part.area, default=shapely.Polygon())

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height."""
        wide, high = np.ptp(self.corners, axis=0)
        return float(wide), float(high)


@dataclass
class Joined:
    """Larger side of a drawing, its closed lines, the pieces that belong to none, and the narrowest gap left."""

    extent_m: float
    closed: list[ClosedLine]
    unused: list[Piece] = field(default_factory=list)
    gap: tuple[float, float, float] | None = None  # its width, and x and y of one of its ends [m]


def extent_of(pieces: Iterable[Piece]) -> float:
    """Larger side of a drawing [m]."""
    corners = np.concatenate([piece.corners for piece in pieces])
    return float(np.ptp(corners, axis=0).max())


def joined(pieces: list[Piece], gap_m: float | None = None) -> Joined:
    """Closed lines of pieces; ends at most `gap_m` apart are joined, those of an open top or outlet by a level line."""
    size = extent_of(pieces)
    gap, exact = GAP * size if gap_m is None else gap_m, EXACT * size
    found, opened = [], []
    for piece in pieces:
        corners = polygons.without_repeats(piece.corners)
        if piece.closed and len(corners) > 2:
            found.append(ClosedLine(piece.layer, corners, oval=piece.oval))
        elif not piece.closed and _length(piece.corners) > exact:
            opened.append(piece)
    if not opened:
        return Joined(size, found)
    opened = _snapped(opened, exact)
    bridges = _bridges(opened, gap)
    loops = _loops(opened, bridges, gap)
    lids = _lids(opened, bridges, gap, found + loops)
    if lids:
        loops += [loop for loop in _loops(opened, bridges, gap, lids) if loop.bridged]
    tree = shapely.STRtree([shapely.LinearRing(one.corners) for one in loops])
    used = set(tree.query(_middles(opened), predicate="dwithin", distance=gap)[0].tolist())
    unused = [one for number, one in enumerate(opened) if number not in used]
    return Joined(size, found + loops, unused, _narrowest(opened, bridges + [line for line, _ in lids]))


def crossing(pieces: list[Piece], gap_m: float | None = None) -> list[ClosedLine]:
    """The fields that lines bound which cross each other, or end on each other's side."""
    size = extent_of(pieces)
    gap, exact = GAP * size if gap_m is None else gap_m, EXACT * size
    lines = [shapely.LineString(_ring(piece)) for piece in pieces if _length(piece.corners) > exact]
    net = shapely.union_all(lines)
    ends = shapely.points([place for line in lines for place in (line.coords[0], line.coords[-1])])
    tree = shapely.STRtree(lines)
    stubs = []
    for number, end in enumerate(ends):
        for other in tree.query(end, predicate="dwithin", distance=gap):
            if other != number // 2:
                nearest = shapely.shortest_line(end, lines[other])
                stubs += [nearest] if nearest.length > 0.0 else []
    whole = shapely.union_all([net, *stubs], grid_size=10.0 ** np.floor(np.log10(exact)))
    rings = [one.exterior for one in shapely.polygonize(shapely.get_parts(whole)).geoms]
    return [ClosedLine(layer, np.array(ring.coords[:-1])) for ring, layer in _with_layers(rings, pieces, gap)]


# --- ends -------------------------------------------------------------------------------------------------------------


def _length(corners: np.ndarray) -> float:
    return float(np.hypot(*np.diff(corners, axis=0).T).sum()) if len(corners) > 1 else 0.0


def _ring(piece: Piece) -> np.ndarray:
    return np.concatenate([piece.corners, piece.corners[:1]]) if piece.closed else piece.corners


def _groups(count: int, pairs: np.ndarray) -> np.ndarray:
    """Number of the group of each of `count` things, of which pairs (2, n) belong together."""
    return connected_components(coo_array((np.ones(pairs.shape[1]), pairs), shape=(count, count)), directed=False)[1]


def _near(ends: np.ndarray, distance: float) -> np.ndarray:
    points = shapely.points(ends)
    return shapely.STRtree(points).query(points, predicate="dwithin", distance=distance)


def _ends(pieces: list[Piece]) -> np.ndarray:
    return np.array([place for piece in pieces for place in (piece.corners[0], piece.corners[-1])])


def _snapped(pieces: list[Piece], exact: float) -> list[Piece]:
    """The pieces, their ends moved onto each other where they are one; each once."""
    ends = _ends(pieces)
    group = _groups(len(ends), _near(ends, exact))
    place = ends[np.unique(group, return_index=True)[1]][group]
    moved: dict[bytes, Piece] = {}
    for number, piece in enumerate(pieces):
        corners = piece.corners.copy()
        corners[0], corners[-1] = place[2 * number], place[2 * number + 1]
        if _length(corners) > exact:
            moved.setdefault(
                shapely.to_wkb(shapely.normalize(shapely.LineString(corners))), Piece(piece.layer, corners, False)
            )
    return list(moved.values())


def _free(pieces: list[Piece], bridges: list[np.ndarray]) -> np.ndarray:
    """Numbers of the ends at which no other piece ends."""
    every = np.concatenate([_ends(pieces), *bridges]) if bridges else _ends(pieces)
    _, inverse, counts = np.unique(every, axis=0, return_inverse=True, return_counts=True)
    return np.flatnonzero(counts[inverse.reshape(-1)][: 2 * len(pieces)] == 1)


def _bridges(pieces: list[Piece], gap: float) -> list[np.ndarray]:
    """Short straight lines (2, 2) between free ends that are each other's nearest within the gap."""
    ends, free = _ends(pieces), _free(pieces, [])
    nearest: dict[int, tuple[float, int]] = {}
    for one, other in _near(ends[free], gap).T if len(free) else ():
        first, second = int(free[one]), int(free[other])
        own = first // 2 == second // 2
        if first == second or own and _length(pieces[first // 2].corners) < 3.0 * gap:
            continue
        distance = float(np.hypot(*(ends[first] - ends[second])))
        nearest[first] = min(nearest.get(first, (np.inf, -1)), (distance, second))
    return [ends[[one, other]] for one, (_, other) in nearest.items() if one < other and nearest[other][1] == one]


def _narrowest(pieces: list[Piece], bridges: list[np.ndarray]) -> tuple[float, float, float] | None:
    free = _free(pieces, bridges)
    ends = _ends(pieces)[free]
    if len(ends) < 2 or len(ends) > 2000:
        return None
    apart = np.hypot(*(ends[:, None] - ends[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    number = int(apart.min(axis=1).argmin())
    return float(apart.min()), float(ends[number, 0]), float(ends[number, 1])


def _lids(
    pieces: list[Piece], bridges: list[np.ndarray], gap: float, closed: list[ClosedLine]
) -> list[tuple[np.ndarray, str]]:
    """Level lines (2, 2) that close what is open at its top or at its bottom, or both, each with its name.

    What is open is a chain of pieces, or two chains that begin and end at the same levels: a left and a right wall.
    """
    ends, free = _ends(pieces), _free(pieces, bridges)
    every = np.concatenate([ends, *bridges]) if bridges else ends
    _, node = np.unique(every, axis=0, return_inverse=True)
    pairs = node.reshape(-1, 2).T
    group = _groups(int(pairs.max()) + 1, pairs)[pairs[0]][: len(pieces)]
    bounds = np.array([[*piece.corners.min(axis=0), *piece.corners.max(axis=0)] for piece in pieces])
    lowest, highest = np.full((len(pieces), 2), np.inf), np.full((len(pieces), 2), -np.inf)  # of each chain
    np.minimum.at(lowest, group, bounds[:, :2])
    np.maximum.at(highest, group, bounds[:, 2:])
    highs = [(highest - lowest)[:, 1].max(), *(one.size_m[1] for one in closed)]
    tall = max(TALL * max(highs), 3.0 * gap)
    found: list[tuple[np.ndarray, str]] = []
    walls: list[list[int]] = []
    for number in sorted(set(group[free // 2].tolist())):
        low, high = float(lowest[number, 1]), float(highest[number, 1])
        if high - low < tall:
            continue
        lids = _level(ends, free[group[free // 2] == number], low, high, gap)
        found += lids
        if not lids:
            alike = [one for one in walls if max(abs(lowest[one[0], 1] - low), abs(highest[one[0], 1] - high)) <= gap]
            if alike:
                alike[0].append(number)
            else:
                walls.append([number])
    for pair in [pair for alike in walls for pair in _facing(alike, lowest[:, 0])]:
        corners = np.array([lowest[pair].min(axis=0), highest[pair].max(axis=0)])
        if not any(_fills(one, corners) for one in closed):
            found += _level(ends, free[np.isin(group[free // 2], pair)], corners[0, 1], corners[1, 1], gap)
    return found


def _facing(walls: list[int], place: np.ndarray) -> list[list[int]]:
    """The left and the right one of walls of equal height; of walls of two lines each, the outer and the inner pair.

    Parameters
    ----------
    walls : numbers of chains.
    place : the leftmost place of each chain.

    """
    if len(walls) == 2:
        return [walls]
    if len(walls) != 4:
        return []
    outer_left, left, right, outer_right = sorted(walls, key=lambda number: place[number])
    thick = max(place[left] - place[outer_left], place[outer_right] - place[right])
    return [[outer_left, outer_right], [left, right]] if thick < THICK * (place[right] - place[left]) else []


def _fills(line: ClosedLine, corners: np.ndarray) -> bool:
    """Whether a closed line stands between two lines, at half their height or more: they are dimension lines."""
    low, high = line.corners.min(axis=0), line.corners.max(axis=0)
    inside = (low >= corners[0]).all() and (high <= corners[1]).all()
    return bool(inside and high[1] - low[1] >= 0.5 * (corners[1, 1] - corners[0, 1]))


def _level(ends: np.ndarray, free: np.ndarray, low: float, high: float, gap: float) -> list[tuple[np.ndarray, str]]:
    """Lines between the outermost of the free ends at the highest, and of those at the lowest level."""
    found = []
    for name, level in (("top", high), ("floor", low)):
        at = sorted((int(end) for end in free if abs(ends[end, 1] - level) <= gap), key=lambda end: ends[end, 0])
        if len(at) > 1 and ends[at[-1], 0] - ends[at[0], 0] > gap:
            found.append((ends[[at[0], at[-1]]], name))
    return found


# --- loops ------------------------------------------------------------------------------------------------------------


def _loops(pieces: list[Piece], bridges: list, gap: float, lids: list | tuple = ()) -> list[ClosedLine]:
    """The fields that pieces bound which end on each other, by way of bridges and of lids."""
    put_in = bridges + [line for line, _ in lids]
    lines = [piece.corners for piece in pieces] + put_in
    found = []
    rings = [one.exterior for one in shapely.polygonize([shapely.LineString(line) for line in lines]).geoms]
    tree = shapely.STRtree([shapely.Point(line.mean(axis=0)) for line in put_in])
    for ring, layer in _with_layers(rings, pieces, gap):
        along = tree.query(ring, predicate="dwithin", distance=polygons.SAME)
        names = [lids[number - len(bridges)][1] for number in sorted(along) if number >= len(bridges)]
        gaps = [_length(bridges[number]) for number in along if number < len(bridges)]
        words = [f"its open {name} was closed by a level line" for name in dict.fromkeys(names)]
        if gaps:
            words.append(f"gaps of up to {max(gaps):.2g} m in it were closed ({len(gaps)})")
        slack = max(gaps, default=0.0)
        found.append(ClosedLine(layer, np.array(ring.coords[:-1]), tuple(words), bool(names), slack_m=slack))
    return found


def _middles(pieces: list[Piece]) -> np.ndarray:
    """A point in the middle of each piece."""
    return shapely.line_interpolate_point([shapely.LineString(one.corners) for one in pieces], 0.5, normalized=True)


def _with_layers(
    rings: list[shapely.LinearRing], pieces: list[Piece], gap: float
) -> Iterator[tuple[shapely.LinearRing, str]]:
    """Closed lines, each with the layers of the pieces along it, as a list in words."""
    tree = shapely.STRtree(_middles(pieces))
    for ring in rings:
        along = tree.query(ring, predicate="dwithin", distance=gap)
        yield ring, ", ".join(sorted({pieces[number].layer for number in along})) or pieces[0].layer
