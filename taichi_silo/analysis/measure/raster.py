"""Fields of scattered points: on a regular raster, and at any place between the points."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

NEIGHBOURS = 12
BELL = 0.45  # standard deviation of the weights in spacings: the least that leaves no steps between points
NEAR = 1.5  # spacings to the nearest point, up to which a place is within the body
AT_ONCE = 1 << 14  # places whose neighbours are sought at once: they take forty times the room of a value
AROUND_MIDDLE = (0.45, 0.55)  # quantiles of some distances between which the median of all is sought


def clean(position: NDArray, *values: NDArray) -> tuple[NDArray, ...]:
    """Return the points (n, 2) and values (n, ...) where all are finite; `ValueError` if lengths differ.

    Where all are, these are the arrays that were given, not to be changed.
    """
    position = np.asarray(position, float)[:, :2]
    arrays = [np.asarray(value, float) for value in values]
    finite = np.isfinite(position).all(axis=1)
    for value in arrays:
        if len(value) != len(position):
            raise ValueError(f"{len(position)} positions, but {len(value)} values")
        finite &= np.isfinite(value).all(axis=tuple(range(1, value.ndim)))
    if finite.all():
        return position, *arrays
    return position[finite], *(value[finite] for value in arrays)


def point_spacing_m(position: NDArray) -> float:
    """Typical distance of neighbouring points [m]: of a square lattice with as many points in as large a body.

    From the distance to the fourth neighbour, so that a lattice and random points give nearly the same.
    """
    distance, _ = cKDTree(position).query(position, k=5)
    return float(np.median(distance[:, 1:].mean(axis=1)))


def by_rows(find: Callable[[slice], NDArray], rows: int, columns: int, kind: type = float) -> NDArray:
    """Field (rows, columns) of what `find` gives for some rows (m, columns), not many at a time."""
    found: NDArray = np.empty((rows, columns), kind)
    at_once = max(1, AT_ONCE // max(columns, 1))
    for first in range(0, rows, at_once):
        found[first : first + at_once] = find(slice(first, first + at_once))
    return found


def crossings(x: NDArray, y: NDArray) -> NDArray:
    """Places (len(y), len(x), 2) where columns x and rows y cross."""
    return np.stack(np.meshgrid(x, y), axis=-1)


def sample(tree: cKDTree, value: NDArray, places: NDArray, spacing_m: float) -> NDArray:
    """Values at places (..., 2): means of the nearest points with the weight exp(-r^2 / (2 (0.45 spacing)^2)).

    A line narrower than a spacing is thus widened to a little more than one; far from all points the value is that of
    the nearest.
    """
    distance, neighbour = tree.query(places, k=min(NEIGHBOURS, tree.n))
    return np.sum(_weights(distance, spacing_m) * np.asarray(value, float)[neighbour], axis=-1)


def inverse_distance_mean(
    tree: cKDTree, value: NDArray, places: NDArray, neighbours: int, typical_m: float | None = None
) -> NDArray:
    """Values at places (..., 2): means of so many nearest points, weighted by 1 / distance^2.

    A thousandth of the typical distance keeps the weight finite on a point: the median over the places, if not told.
    """
    distance, neighbour = tree.query(places, k=neighbours)
    typical_m = float(np.median(distance)) if typical_m is None else typical_m
    weight = 1.0 / (distance**2 + 1e-6 * typical_m**2)
    return np.sum(weight * np.asarray(value, float)[neighbour], axis=-1) / np.sum(weight, axis=-1)


def median_distance(tree: cKDTree, x: NDArray, y: NDArray, neighbours: int) -> float:
    """Median of the distances from where columns x and rows y cross to the nearest points; only the middle is kept."""
    at_once, count = max(1, AT_ONCE // len(x)), neighbours * len(x) * len(y)
    ranges: list[tuple] = [(0.0, np.inf)]
    if len(y) > at_once:  # some places tell where the middle is, nearly always
        some = np.random.default_rng(0).integers(0, (len(x), len(y)), (AT_ONCE, 2))
        near = tree.query(np.stack([x[some[:, 0]], y[some[:, 1]]], axis=-1), k=neighbours)[0]
        ranges.insert(0, tuple(np.quantile(near, AROUND_MIDDLE)))
    for low, high in ranges:
        below, between = 0, []
        for first in range(0, len(y), at_once):
            distance = tree.query(crossings(x, y[first : first + at_once]), k=neighbours)[0].ravel()
            below += int((distance < low).sum())
            between.append(distance[(distance >= low) & (distance <= high)])
        kept = np.sort(np.concatenate(between))
        first, last = (count - 1) // 2 - below, count // 2 - below
        if first >= 0 and last < len(kept):
            break
    return float(np.mean(kept[[first, last]]))


def first_fall(places: NDArray, values: NDArray, threshold: float, never: float) -> float:
    """First place along a profile that begins above the threshold where it falls to it; `never` if it does not."""
    below = np.flatnonzero(values < threshold)
    if not len(below):
        return never
    after, before = below[0], below[0] - 1
    share = (values[before] - threshold) / (values[before] - values[after])
    return float(places[before] + share * (places[after] - places[before]))


def within(tree: cKDTree, places: NDArray, spacing_m: float) -> NDArray:
    """Whether places (..., 2) are in the body: a point is nearer than 1.5 spacings."""
    distance, _ = tree.query(places)
    return distance < NEAR * spacing_m


def _weights(distance: NDArray, spacing_m: float) -> NDArray:
    """Bell-shaped weights (..., k) of the k nearest points, whose sum is 1."""
    exponent = (distance**2 - distance[..., :1] ** 2) / (2.0 * (BELL * spacing_m) ** 2)
    weight = np.exp(-exponent)  # relative to the nearest point: finite far from all
    return weight / weight.sum(axis=-1, keepdims=True)


@dataclass(frozen=True)
class Raster:
    """Square cells between the walls x = 0 and x = width, from a bottom upwards."""

    x_m: NDArray  # (columns,) middles of the cells
    y_m: NDArray  # (rows,)
    cell_m: float  # side of a cell
    inside: NDArray  # (rows, columns) whether a cell is in the body
    tree: cKDTree  # of the points
    spacing_m: float  # of the points

    @classmethod
    def over(
        cls,
        position: NDArray,
        width_m: float,
        spacing_m: float,
        bottom_m: float | None = None,
        top_m: float | None = None,
        cells: float = 1.0,
    ) -> "Raster":
        """Raster over points (n, 2) with `cells` cells a spacing; from the lowest to the highest point if not told."""
        bottom_m = position[:, 1].min() - 0.5 * spacing_m if bottom_m is None else bottom_m
        top_m = position[:, 1].max() + 0.5 * spacing_m if top_m is None else top_m
        columns = max(4, int(np.ceil(cells * width_m / spacing_m - 1e-6)))
        cell = width_m / columns
        rows = max(4, int(np.ceil((top_m - bottom_m) / cell - 1e-6)))
        x, y = (np.arange(columns) + 0.5) * cell, bottom_m + (np.arange(rows) + 0.5) * cell
        tree = cKDTree(position)
        inside = by_rows(lambda part: within(tree, crossings(x, y[part]), spacing_m), rows, columns, bool)
        return cls(x, y, cell, inside, tree, spacing_m)

    def of(self, value: NDArray) -> NDArray:
        """Field (rows, columns) of values (n,): at each cell their `sample`."""
        return by_rows(
            lambda rows: sample(self.tree, value, crossings(self.x_m, self.y_m[rows]), self.spacing_m),
            *self.inside.shape,
        )

    def at(self, field: NDArray, places: NDArray) -> NDArray:
        """Values of a field (rows, columns) at places (..., 2), bilinear, constant outside the middles."""
        from scipy.ndimage import map_coordinates  # it takes a tenth of a second

        column, row = (places[..., k] - first for k, first in ((0, self.x_m[0]), (1, self.y_m[0])))
        return map_coordinates(field, [row / self.cell_m, column / self.cell_m], order=1, mode="nearest")
