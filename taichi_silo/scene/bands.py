"""Friction that differs from wall to wall, or along a wall: bands of the side walls with an angle of their own."""

import math
from itertools import combinations
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from taichi_silo.utils.schema import Options

if TYPE_CHECKING:
    from taichi_silo.scene.silo import Silo
    from taichi_silo.scene.walls import Walls

MOST_BANDS = 50
VERY_ROUGH = -1.0  # in place of a friction coefficient: no slip


class Band(Options):
    """Part of the side walls with friction of its own, such as a liner, or one wall of two."""

    wall: Literal["both", "left", "right"] = Field("both", description="which walls have it")
    from_m: float = Field(0.0, ge=0, le=1000, description="height of its lower end above the floor or outlet")
    to_m: float | None = Field(None, gt=0, le=1000, description="height of its upper end; the wall's top if absent")
    friction_angle_deg: float = Field(ge=0, lt=90, description="between sand and wall there")

    @model_validator(mode="after")
    def _rises(self):
        if self.to_m is not None and self.to_m <= self.from_m:
            raise ValueError(f"band of the walls is from {self.from_m:g} to {self.to_m:g} m; to_m must be above from_m")
        return self

    @property
    def top_m(self) -> float:
        """Its upper end [m]; inf if it has none."""
        return math.inf if self.to_m is None else self.to_m

    def on(self, wall: str) -> bool:
        """Whether the "left" or "right" wall has it."""
        return self.wall in ("both", wall)

    def words(self) -> str:
        """Angle and place."""
        upper = "upwards" if self.to_m is None else f"to {1e3 * self.to_m:g} mm"
        place = "" if self.from_m == 0.0 and self.to_m is None else f" from {1e3 * self.from_m:g} {upper}"
        return f"{self.friction_angle_deg:g}°{'' if self.wall == 'both' else f' {self.wall}'}{place}"


def check(walls: "Walls", silo: "Silo") -> None:
    """Refuse bands that lie in each other, above the sand, or on one side of a round silo: a ValueError."""
    for one, other in combinations(walls.bands, 2):
        if (one.wall == other.wall or "both" in (one.wall, other.wall)) and max(one.from_m, other.from_m) < min(
            one.top_m, other.top_m
        ):
            raise ValueError(f"bands of the walls of {one.words()} and {other.words()} overlap; they must lie apart")
    for band in walls.bands:
        if band.from_m >= silo.height_m:
            raise ValueError(
                f"band of the walls begins at {band.from_m:g} m; it must begin below the surface of the fill at "
                f"{silo.height_m:g} m"
            )
        if silo.section == "round" and band.wall != "both":
            raise ValueError(f"band's wall is {band.wall}; a round silo has one wall: it must be both")


def alike(walls: "Walls") -> bool:
    """Whether both walls have the same friction."""
    left, right = (sorted((b.from_m, b.top_m, b.friction_angle_deg) for b in walls.bands if b.on(wall))
                   for wall in ("left", "right"))  # fmt: skip
    return left == right


def words(walls: "Walls") -> str:
    """The bands, as titles of figures name them; empty without."""
    return ", ".join(band.words() for band in walls.bands)


def coefficient(walls: "Walls", wall: str, low_m: ArrayLike, high_m: ArrayLike) -> np.ndarray:
    """Mean friction coefficient of a wall between heights (n,) [m]; `VERY_ROUGH` where that is most of it.

    Above the fill's surface, and below the floor, a wall goes on as it is there.
    """
    low, high = np.asarray(low_m, float), np.asarray(high_m, float)
    own = walls.friction_angle_deg
    share, total = np.zeros(low.shape), np.zeros(low.shape)
    for band in walls.bands:
        if band.on(wall):
            bottom = -math.inf if band.from_m == 0.0 else band.from_m
            part = np.clip((np.minimum(high, band.top_m) - np.maximum(low, bottom)) / (high - low), 0.0, 1.0)
            share, total = share + part, total + part * math.tan(math.radians(band.friction_angle_deg))
    if own is not None:
        return total + (1.0 - share) * math.tan(math.radians(own))
    return np.where(share > 0.5, total / np.maximum(share, 0.5), VERY_ROUGH)


def levels(walls: "Walls", low_m: float, high_m: float) -> np.ndarray:
    """Heights between two where the friction of a wall changes, with both [m]."""
    ends = {end for band in walls.bands for end in (band.from_m, band.top_m) if low_m < end < high_m}
    return np.array([low_m, *sorted(ends), high_m])
