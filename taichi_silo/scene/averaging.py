"""The non-local mean that a user gives: its length, its weight, and how it is summed."""

from typing import Literal

from pydantic import Field

from taichi_silo.mpm.neighbour_rows import MOST_PAIRS, most_pairs
from taichi_silo.mpm.nonlocal_average import INACTIVE_FROM, WEIGHTS, Weight, self_weight, summed_by
from taichi_silo.scene.sand import Sand
from taichi_silo.utils.schema import Options

OF_CELL = 0.5  # of a cell, the shortest length between very rough walls: with less N there is up to a quarter too high


class Averaging(Options):
    """Non-local mean of the norm of the strain rate in the law's non-linear part."""

    characteristic_length_m: float | None = Field(
        None,
        ge=0,
        le=1000,
        description="characteristic length of the non-local law, 0 for a local law; if absent 3 d50, or half "
        "a cell if that is more and a whole bottom sinks under dense sand between very rough walls",
    )
    weight: Literal["gaussian", "exponential"] = Field(
        "gaussian", description="weight of neighbours; the paper prints exponential"
    )
    wall: Literal["ignored", "rigid"] | None = Field(
        None,
        description="very rough straight walls in the mean: left out, or counted as grains that do not strain; rigid "
        "if absent, ignored with another weight than gaussian",
    )

    def length_m(self, sand: Sand, cell_m: float = 0.0) -> float:
        """Characteristic length l_c [m]: as given, or three mean grain diameters, or half a cell if that is more."""
        if self.characteristic_length_m is not None:
            return self.characteristic_length_m
        return max(3.0 * sand.d50_m, OF_CELL * cell_m)

    means: Literal["grid", "rows"] | None = Field(
        None,
        description="how the mean is summed: over rows of neighbours, or, a Gaussian, by way of a grid; the faster one "
        "if absent",
    )

    def summed_by(self, kernel: Weight, spacing_m: float, half: bool = False) -> str:
        """How the mean is summed: "grid" or "rows", which a half model cannot have."""
        if self.means is None and half and self.weight == "gaussian":
            return "grid"
        return self.means or summed_by(kernel, spacing_m)

    @property
    def walls_count(self) -> bool:
        """Whether walls that sand sticks to count in the mean."""
        return self.weight == "gaussian" if self.wall is None else self.wall == "rigid"

    def check(self, length: float, spacing_m: float, points: int, width_m: float) -> None:
        """Refuse a characteristic length beyond the body, or with more neighbours than memory holds."""
        if self.wall == "rigid" and self.weight != "gaussian":
            raise ValueError(f"weight is {self.weight}; with walls that count as rigid it must be gaussian")
        name = f"characteristic length is {length:g} m"
        if self.characteristic_length_m is None:
            name = f"sand.d50_m is {length / 3.0:g} m, and three of it make a characteristic length of {length:g} m"
        if length > width_m:
            raise ValueError(f"{name}; it must be between 0 and the width of {width_m:g} m")
        if self.means == "grid" and self.weight != "gaussian":
            raise ValueError(f"weight is {self.weight}; summed by a grid it must be gaussian")
        kernel = WEIGHTS[self.weight](length)
        by_rows = length > 0.0 and self.summed_by(kernel, spacing_m) == "rows"
        if by_rows and most_pairs(kernel.radius, spacing_m, points) > MOST_PAIRS:
            raise ValueError(
                f"{name}; with {points} points {1e3 * spacing_m:g} mm apart that makes "
                f"more than {MOST_PAIRS} pairs of neighbours, give a smaller one, larger cells, or the means by a grid"
            )

    def kernel(self, length: float, spacing_m: float) -> tuple[Weight | None, str]:
        """Weight function of the average over a length, None where it would change nothing, and why in a sentence."""
        if length == 0.0:
            return None, "The law is local: the characteristic length is 0."
        kernel = WEIGHTS[self.weight](length)
        own = self_weight(kernel, spacing_m)
        apart = (
            f"with points {1e3 * spacing_m:g} mm apart and a characteristic length of {1e3 * length:g} mm a point's "
            "own weight is"
        )
        if own > INACTIVE_FROM:
            return None, (
                f"Non-locality is inactive: {apart} {own:.4f}; points closer than {1e3 * length:g} mm would make it "
                "work."
            )
        return kernel, f"Non-locality is active: {apart} {own:.3f}."
