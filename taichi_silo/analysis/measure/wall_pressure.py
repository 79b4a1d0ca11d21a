"""Wall stress as a pressure cell reads it, and where along a wall stresses mean something."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MODEL_WIDTH_M = 0.2  # of the model silo, in which
CELL_M = 0.02  # is the height of a pressure cell [m]: a usual size in model silos;
HOPPER_CELL_M = 0.05  # that on inclined walls [m], where single rows of the grid mean little;
CORNER_M = 0.0125  # the height above the bottom [m] below which stresses belong to the corner
SURFACE = 0.9  # of the fill height: above, the stress is a few pascals, and the law is not calibrated for it


@dataclass(frozen=True)
class Reading:
    """Lengths over which wall stresses are read: those of the model silo, or of one of another size."""

    cell_m: float = CELL_M
    hopper_cell_m: float = HOPPER_CELL_M
    corner_m: float = CORNER_M

    @classmethod
    def of(cls, width_m: float, height_m: float) -> "Reading":
        """They grow with the width of a silo, in one that is wider than high with its height."""
        size = min(width_m, max(height_m, MODEL_WIDTH_M)) / MODEL_WIDTH_M
        return cls(size * CELL_M, size * HOPPER_CELL_M, size * CORNER_M)


MODEL = Reading()


def clear_of_corner(height_m: NDArray, reading: Reading) -> NDArray:
    """Which nodes, by their rising heights (n,) [m], have a pressure cell that does not reach into the corner."""
    return height_m > np.min(height_m, initial=np.inf) + reading.corner_m + 0.5 * reading.cell_m


def cell_mean(height_m: NDArray, stress_Pa: NDArray, cell_m: float) -> NDArray:
    """Mean (n,) of the nodal stress (piecewise linear) over a pressure cell centred at each node, of rising heights.

    Near an end the cell is cut off there. A stress that alternates from node to node averages out.
    """
    height, stress = np.asarray(height_m, float), np.asarray(stress_Pa, float)
    if len(height) < 2:
        return stress.copy()
    integral = np.insert(np.cumsum(0.5 * (stress[1:] + stress[:-1]) * np.diff(height)), 0, 0.0)

    def up_to(place: NDArray) -> NDArray:
        """Exact integral of the piecewise linear stress."""
        k = np.clip(np.searchsorted(height, place, side="right") - 1, 0, len(height) - 2)
        part = place - height[k]
        slope = (stress[k + 1] - stress[k]) / (height[k + 1] - height[k])
        return integral[k] + stress[k] * part + 0.5 * slope * part**2

    low, high = np.maximum(height - 0.5 * cell_m, height[0]), np.minimum(height + 0.5 * cell_m, height[-1])
    return (up_to(high) - up_to(low)) / (high - low)
