"""A body inside the sand."""

import math
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from taichi_silo.scene import polygons
from taichi_silo.utils.schema import Options


class Insert(Options):
    """A body inside the sand, across the whole silo: a roof (a triangle on its base), a cylinder, or any polygon."""

    kind: Literal["roof", "cylinder", "polygon"] = Field(description="kind of body")
    width_m: float | None = Field(None, ge=1e-4, le=1000, description="width of the roof's base, or diameter")
    height_m: float | None = Field(None, ge=1e-4, le=1000, description="height of a roof; as high as wide if absent")
    bottom_m: float | None = Field(
        None, gt=0, le=1000, description="lowest place of a roof or cylinder above the floor"
    )
    position_m: float | None = Field(None, gt=0, le=1000, description="x of its middle; the silo's if absent")
    corners_m: polygons.Corners | None = Field(
        None, max_length=polygons.MOST_CORNERS, description="corners (x, y) of a polygon, in any sense"
    )
    friction_angle_deg: float | None = Field(None, ge=0, lt=90, description="of its surface; the walls' if absent")

    @model_validator(mode="after")
    def _complete(self):
        of_body = {name: getattr(self, name) for name in ("width_m", "height_m", "bottom_m", "position_m")}
        if self.kind == "polygon":
            if self.corners_m is None or any(value is not None for value in of_body.values()):
                raise ValueError("an insert of kind polygon has corners_m, and no width, height, bottom or position")
            polygons.polygon(self.corners_m, "insert")
        elif self.corners_m is not None:
            raise ValueError(f"a {self.kind} has no corners_m; only an insert of kind polygon has")
        elif missing := [name for name in ("width_m", "bottom_m") if of_body[name] is None]:
            raise ValueError(f"a {self.kind} needs width_m and bottom_m; {' and '.join(missing)} must be given")
        return self

    @classmethod
    def polygon(cls, corners_m: Iterable[Sequence[float]], friction_angle_deg: float | None = None) -> "Insert":
        """An insert of any shape from its corners (x, y) [m], in any sense."""
        corners = tuple((float(x), float(y)) for x, y in corners_m)
        return cls(kind="polygon", corners_m=corners, friction_angle_deg=friction_angle_deg)

    @property
    def _corners(self) -> np.ndarray:
        return np.array(self.corners_m)

    @property
    def rise_m(self) -> float:
        """Height of the body [m]."""
        if self.kind == "polygon":
            return float(np.ptp(self._corners[:, 1]))
        return self.breadth_m if self.kind == "cylinder" or self.height_m is None else self.height_m

    @property
    def breadth_m(self) -> float:
        """Width of the body [m]."""
        return self.width_m or float(np.ptp(self._corners[:, 0]))

    def centre_m(self, silo_width_m: float) -> float:
        """X of its middle [m], from the left wall."""
        if self.kind == "polygon":
            return float(0.5 * (self._corners[:, 0].min() + self._corners[:, 0].max()))
        return 0.5 * silo_width_m if self.position_m is None else self.position_m

    def outline(self, silo_width_m: float, corners: int = 48) -> np.ndarray:
        """Corners (n, 2) of its section, anticlockwise [m]; a cylinder is a polygon of that many corners."""
        if self.kind == "polygon":
            return polygons.polygon(self.corners_m or (), "insert")
        x, low = self.centre_m(silo_width_m), self.bottom_m or 0.0
        if self.kind == "roof":
            half = 0.5 * self.breadth_m
            return np.array([[x - half, low], [x + half, low], [x, low + self.rise_m]])
        turn = 2.0 * np.pi * np.arange(corners) / corners
        radius = 0.5 * self.breadth_m
        return np.array([x, low + radius]) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)

    def area_m2(self) -> float:
        """Area of its section [m2]."""
        if self.kind == "cylinder":
            return 0.25 * math.pi * self.breadth_m**2
        return polygons.area(self.outline(0.0))

    def contains(self, x: ArrayLike, y: ArrayLike, silo_width_m: float) -> np.ndarray:
        """Whether points x, y (arrays) [m] lie inside it."""
        if self.kind == "cylinder":
            right, up = np.asarray(x) - self.centre_m(silo_width_m), np.asarray(y) - (self.bottom_m or 0.0)
            radius = 0.5 * self.breadth_m
            return right**2 + (up - radius) ** 2 < radius**2
        return polygons.inside(x, y, self.outline(silo_width_m))

    def words(self) -> str:
        """Its kind and width, as titles of figures name it."""
        return f"{'insert' if self.kind == 'polygon' else self.kind} of {1e3 * self.breadth_m:g} mm"
