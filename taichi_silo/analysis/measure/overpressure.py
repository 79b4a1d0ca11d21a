"""The largest over-pressure on a wall: normal stress during flow over that at the end of filling, at the same height.

Both are read as a pressure cell reads them (`wall_pressure.cell_mean`). Left out are the corner, where the bottom
carries part of the stress and a little rearrangement multiplies it, and the top, where the filling stress is below a
tenth of its greatest value on that wall and the quotient means nothing.

Known limits: a single record counts, so noise in time should have been averaged out before (mean over a period of the
column or more); stresses nearer to each other than a cell are not told apart; the factor holds for these heights, and
the greatest stress anywhere may lie elsewhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichi_silo.analysis.measure.wall_pressure import MODEL, Reading, cell_mean

LEAST_SHARE = 0.1  # of the greatest filling stress on a wall; below, no factor


@dataclass(frozen=True)
class Overpressure:
    """The largest factor, and where and when; nan (and wall and record -1) if there is no place to measure."""

    factor: float  # normal stress over that at the end of filling [-]
    wall: int  # index of the wall
    height_m: float
    time_s: float
    displacement_m: float  # of the bottom; nan if it was not given
    record: int  # index of the time
    stress_Pa: float  # as the cell reads it
    filling_stress_Pa: float  # the same
    factor_by_height: NDArray  # (walls, heights) largest factor over time; nan where none is measured


def largest_overpressure(
    time_s: NDArray,
    height_m: NDArray,
    normal_stress_Pa: NDArray,
    filling_stress_Pa: NDArray,
    displacement_m: NDArray | None = None,
    reading: Reading = MODEL,
) -> Overpressure:
    """Find the largest over-pressure factor of a history of wall stresses.

    Parameters
    ----------
    time_s : (times,) times of the records [s].
    height_m : (heights,) rising heights of the nodes over the bottom, the same for all walls [m].
    normal_stress_Pa : (times, walls, heights) normal stress, positive in compression [Pa]; nan where there is none.
    filling_stress_Pa : (walls, heights) the same at the end of filling [Pa].
    displacement_m : (times,) of the bottom [m], optional.
    reading : lengths of pressure cell and corner; those of the model silo if not told.

    Raises ValueError if shapes do not fit or heights do not rise.
    """
    time, height = np.atleast_1d(np.asarray(time_s, float)), np.asarray(height_m, float)
    stress, filling = np.asarray(normal_stress_Pa, float), np.asarray(filling_stress_Pa, float)
    if filling.ndim != 2 or filling.shape[1] != len(height) or stress.shape != (len(time), *filling.shape):
        raise ValueError(
            f"shapes do not fit: {len(time)} times, {len(height)} heights, stresses {stress.shape}, "
            f"at the end of filling {filling.shape}"
        )
    if (np.diff(height) <= 0.0).any():
        raise ValueError("heights must rise from node to node")
    displacement = np.full(len(time), np.nan) if displacement_m is None else np.asarray(displacement_m, float)
    if displacement.shape != time.shape:
        raise ValueError(f"{len(time)} times, but {displacement.size} displacements")

    reader = np.column_stack([cell_mean(height, node, reading.cell_m) for node in np.eye(len(height))])
    read, before = _read(reader, stress), _read(reader, filling)
    highest = np.nanmax(before, axis=1, keepdims=True, initial=0.0)
    clear = height >= height[0] + reading.corner_m + 0.5 * reading.cell_m - 1e-9
    measured = clear & (before >= LEAST_SHARE * highest) & (before > 0.0)
    quotient = np.where(measured, read / np.where(measured, before, 1.0), np.nan)
    by_height = np.max(np.where(np.isnan(quotient), -np.inf, quotient), axis=0, initial=-np.inf)
    by_height = np.where(np.isfinite(by_height), by_height, np.nan)
    if np.isnan(by_height).all():
        return Overpressure(np.nan, -1, np.nan, np.nan, np.nan, -1, np.nan, np.nan, by_height)
    record, wall, node = np.unravel_index(np.nanargmax(quotient), quotient.shape)
    where = int(wall), float(height[node]), float(time[record]), float(displacement[record]), int(record)
    stresses = float(read[record, wall, node]), float(before[wall, node])
    return Overpressure(float(quotient[record, wall, node]), *where, *stresses, by_height)


def _read(reader: NDArray, stress: NDArray) -> NDArray:
    """Cell means of stresses (..., heights); nan where the cell covers a node without stress."""
    known = np.isfinite(stress)
    mean = np.where(known, stress, 0.0) @ reader.T
    return np.where((~known).astype(float) @ np.abs(reader.T) > 1e-12, np.nan, mean)
