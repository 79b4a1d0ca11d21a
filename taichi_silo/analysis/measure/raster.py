"""Fields of scattered points: on a regular raster, and at any place between the points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

NEIGHBOURS = 12
BELL = 0.45  # standard deviation of the weights in spacings: the least that leaves no steps between points
NEAR = 1.5  # spacings to the nearest point, up to which a place is within the body


def clean(position: NDArray, *values: NDArray) -> tuple[NDArray, ...]:
    """Return the points (n, 2) and values (n, ...) where all are finite; `ValueError` if lengths differ."""
    position = np.asarray(position, float)[:, :2]
    arrays = [np.asarray(value, float) for value in values]
    finite = np.isfinite(position).all(axis=1)
    for value in arrays:
        if len(value) != len(position):
            raise ValueError(f"{len(position)} positions, but {len(value)} values")
        finite &= np.isfinite(value).all(axis=tuple(range(1, value.ndim)))
    return position[finite], *(value[finite] for value in arrays)


def point_spacing_m(position: NDArray) -> float:
    """Typical distance of neighbouring points [m]: of a square lattice with as many points in as large a body.

    From the distance to the fourth neighbour, so that a lattice and random points give nearly the same.
    """
    distance, _ = cKDTree(position).query(position, k=5)
    return float(np.median(distance[:, 1:].mean(axis=1)))


def sample(position: NDArray, value: NDArray, places: NDArray, spacing_m: float) -> NDArray:
    """Values at places (..., 2): means of the nearest points with the weight exp(-r^2 / (2 (0.45 spacing)^2)).

    A line narrower than a spacing is thus widened to a little more than one; far from all points the value is that of
    the nearest.
    """
    distance, neighbour = cKDTree(position).query(places, k=min(NEIGHBOURS, len(position)))
    return np.sum(_weights(distance, spacing_m) * np.asarray(value, float)[neighbour], axis=-1)


def inverse_distance_mean(position: NDArray, value: NDArray, places: NDArray, neighbours: int) -> NDArray:
    """Values at places (..., 2): means of so many nearest points, weighted by 1 / distance^2."""
    distance, neighbour = cKDTree(position).query(places, k=neighbours)
    weight = 1.0 / (distance**2 + 1e-6 * np.median(distance) ** 2)  # finite on a point
    return np.sum(weight * np.asarray(value, float)[neighbour], axis=-1) / np.sum(weight, axis=-1)


def first_fall(places: NDArray, values: NDArray, threshold: float, never: float) -> float:
    """First place along a profile that begins above the threshold where it falls to it; `never` if it does not."""
    below = np.flatnonzero(values < threshold)
    if not len(below):
        return never
    after, before = below[0], below[0] - 1
    share = (values[before] - threshold) / (values[before] - values[after])
    return float(places[before] + share * (places[after] - places[before]))


def within(position: NDArray, places: NDArray, spacing_m: float) -> NDArray:
    """Whether places (..., 2) are in the body: a point is nearer than 1.5 spacings."""
    distance, _ = cKDTree(position).query(places)
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
    weight: NDArray  # (rows, columns, k) of the points of each cell
    neighbour: NDArray  # (rows, columns, k) these points

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
        places = np.stack(np.meshgrid(x, y), axis=-1)
        distance, neighbour = cKDTree(position).query(places, k=min(NEIGHBOURS, len(position)))
        return cls(x, y, cell, distance[..., 0] < NEAR * spacing_m, _weights(distance, spacing_m), neighbour)

    def of(self, value: NDArray) -> NDArray:
        """Field (rows, columns) of values (n,)."""
        return np.sum(self.weight * np.asarray(value, float)[self.neighbour], axis=-1)

    def at(self, field: NDArray, places: NDArray) -> NDArray:
        """Values of a field (rows, columns) at places (..., 2), bilinear, constant outside the middles."""
        from scipy.ndimage import map_coordinates  # it takes a tenth of a second

        column, row = (places[..., k] - first for k, first in ((0, self.x_m[0]), (1, self.y_m[0])))
        return map_coordinates(field, [row / self.cell_m, column / self.cell_m], order=1, mode="nearest")
