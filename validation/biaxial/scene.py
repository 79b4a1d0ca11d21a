"""The input of a biaxial test."""

import math
from typing import Literal

from pydantic import Field, model_validator

from taichi_silo.scene.method_options import MethodOptions, Shape
from taichi_silo.scene.scene import MOST_POINTS, Averaging, Machine, Sand


class BiaxialScene(MethodOptions):
    """A specimen between two smooth plates, in a fluid under pressure; the upper plate goes down."""

    sand: Sand = Sand(void_ratio=0.55)
    width_m: float = Field(0.04, ge=1e-3, le=10)
    height_m: float = Field(0.14, ge=1e-3, le=10)
    points_across: int = Field(32, ge=4, le=400, description="points along the width")
    points_per_cell: Literal[1, 4, 9] = 4
    shape: Shape = "ugimp"
    pressure_Pa: float = Field(50e3, ge=100.0, le=5e6, description="of the fluid around the sides")
    weak_void_ratio: float = Field(0.91, description="of the weak element on the left")
    weak_size_m: float = Field(0.005, ge=0, description="at most half of the width")
    weak_height: float = Field(0.55, gt=0, lt=1, description="of its middle, over the specimen's height")
    averaging: Averaging = Averaging()
    speed_m_per_s: float = Field(0.05, ge=1e-6, le=10, description="of the upper plate")
    shortening: float = Field(0.05, gt=0, le=0.3, description="at the end, u / height")
    gravity_m_per_s2: float = Field(9.81, ge=0)
    noise_control: Literal["column", "none"] = "column"
    machine: Machine = Machine()

    @model_validator(mode="after")
    def _fits(self):
        per_axis = math.isqrt(self.points_per_cell)
        rows = self.height_m / self.spacing_m
        if self.points_across % (2 * per_axis) or abs(rows - round(rows)) > 1e-6 or round(rows) % per_axis:
            raise ValueError(
                f"points across is {self.points_across}; with {self.points_per_cell} points a cell it must be a "
                f"multiple of {2 * per_axis}, and the cells must divide the height of {1e3 * self.height_m:g} mm"
            )
        if self.points_across * rows > MOST_POINTS:
            raise ValueError(
                f"points across is {self.points_across}; that makes {self.points_across * rows:.0f} points, at most "
                f"{MOST_POINTS} are allowed"
            )
        if self.weak_size_m > 0.5 * self.width_m:
            raise ValueError(f"weak size is {self.weak_size_m} m; it must be at most {0.5 * self.width_m}")
        self.averaging.check(
            self.averaging.length_m(self.sand), self.spacing_m, self.points_across * round(rows), self.width_m
        )
        self.sand.check_at(self.pressure_Pa)
        self.sand.model_copy(update={"void_ratio": self.weak_void_ratio}).check_at(self.pressure_Pa, "weak void ratio")
        return self

    @property
    def spacing_m(self) -> float:
        """Spacing of the points."""
        return self.width_m / self.points_across

    @property
    def cell_size_m(self) -> float:
        """Size of the grid's cells."""
        return self.spacing_m * math.isqrt(self.points_per_cell)
