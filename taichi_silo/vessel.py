"""The silo that a user gives: walls, outlet, hopper, inserts, and which of its places hold sand.

Coordinates are those of the laboratory: x from the left wall, y from the floor (of a hopper: from its outlet), upwards.
A round silo is described by its section through the axis, which stands at half the width.
"""

import math
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from taichi_silo.table import Table


class Outlet(Table):
    """An opening of the flat floor; without it the whole floor is the outlet."""

    width_m: float = Field(gt=0)
    position: Literal["centre", "left", "right"] = "centre"


class Hopper(Table):
    """Walls that converge towards an outlet, which is as wide as their lower ends are apart."""

    half_angle_deg: float = Field(gt=0, lt=80, description="of the walls, from the vertical")
    outlet_width_m: float = Field(gt=0)
    friction_angle_deg: float | None = Field(None, ge=0, lt=90, description="that of the side walls if absent")


class Insert(Table):
    """A body inside the sand: a roof (a triangle on its base) or a cylinder, across the whole silo."""

    kind: Literal["roof", "cylinder"]
    width_m: float = Field(gt=0, description="of the roof's base; diameter of the cylinder")
    height_m: float | None = Field(None, gt=0, description="of a roof above its base; as high as wide if absent")
    bottom_m: float = Field(gt=0, description="lowest place above the floor")
    position_m: float | None = Field(None, gt=0, description="of its middle; that of the silo if absent")
    friction_angle_deg: float | None = Field(None, ge=0, lt=90, description="that of the side walls if absent")

    @property
    def rise_m(self) -> float:
        """Height of the body."""
        if self.kind == "cylinder":
            return self.width_m
        return self.width_m if self.height_m is None else self.height_m

    def centre_m(self, silo_width_m: float) -> float:
        """Where its middle stands."""
        return 0.5 * silo_width_m if self.position_m is None else self.position_m

    def outline(self, silo_width_m: float, corners: int = 48) -> np.ndarray:
        """Corners (n, 2), anticlockwise [m]."""
        x, low = self.centre_m(silo_width_m), self.bottom_m
        if self.kind == "roof":
            half = 0.5 * self.width_m
            return np.array([[x - half, low], [x + half, low], [x, low + self.rise_m]])
        turn = 2.0 * np.pi * np.arange(corners) / corners
        radius = 0.5 * self.width_m
        return np.array([x, low + radius]) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)

    def area_m2(self) -> float:
        """Of its section."""
        return 0.5 * self.width_m * self.rise_m if self.kind == "roof" else 0.25 * math.pi * self.width_m**2

    def contains(self, x, y, silo_width_m: float):
        """Whether places (arrays) lie inside."""
        right, up = np.asarray(x) - self.centre_m(silo_width_m), np.asarray(y) - self.bottom_m
        if self.kind == "cylinder":
            radius = 0.5 * self.width_m
            return right**2 + (up - radius) ** 2 < radius**2
        return (up > 0.0) & (np.abs(right) < 0.5 * self.width_m * (1.0 - up / self.rise_m))


class Silo(Table):
    """Two parallel walls, or a round one, with what closes it below; forces are per metre run (of the wall's girth)."""

    width_m: float = Field(0.2, gt=0, description="or diameter")
    height_m: float = Field(0.5, gt=0, description="height of the fill above the floor, a hopper included")
    section: Literal["plane", "round"] = "plane"
    half: Literal["auto", "yes", "no"] = Field("auto", description="compute one half and mirror it; see symmetry.py")
    outlet: Outlet | None = None
    hopper: Hopper | None = None
    inserts: tuple[Insert, ...] = ()

    @model_validator(mode="after")
    def _fits(self):
        wide = self.width_m
        if self.outlet is not None and self.hopper is not None:
            raise ValueError("a silo has an outlet in its floor or a hopper, not both: a hopper ends in its own outlet")
        if self.outlet is not None and not self.outlet.width_m < wide:
            raise ValueError(f"outlet width is {self.outlet.width_m} m; it must be below the silo's width of {wide} m")
        if self.hopper is not None:
            if not self.hopper.outlet_width_m < wide:
                raise ValueError(
                    f"outlet width of the hopper is {self.hopper.outlet_width_m} m; it must be below the silo's width "
                    f"of {wide} m"
                )
            if not self.transition_m < self.height_m:
                raise ValueError(
                    f"half angle of the hopper is {self.hopper.half_angle_deg} deg; it makes the hopper "
                    f"{self.transition_m:.4g} m high, which must be below the fill's height of {self.height_m} m"
                )
        for insert in self.inserts:
            self._check(insert)
        if self.section == "round":
            self._check_round()
        return self

    def _check(self, insert: Insert) -> None:
        outline = insert.outline(self.width_m)
        left, right = self.between(outline[:, 1])
        if (outline[:, 0] <= left).any() or (outline[:, 0] >= right).any():
            raise ValueError(
                f"the {insert.kind} between x = {outline[:, 0].min():.4g} and {outline[:, 0].max():.4g} m must stand "
                f"free of the walls of a silo {self.width_m} m wide"
            )
        if outline[:, 1].max() >= self.height_m:
            raise ValueError(
                f"the {insert.kind} reaches up to {outline[:, 1].max():.4g} m; it must be below the surface of the "
                f"fill at {self.height_m} m"
            )

    def _check_round(self) -> None:
        if self.outlet is not None and self.outlet.position != "centre":
            raise ValueError(
                f"outlet position is {self.outlet.position}; in a round silo, computed by its section, it must be "
                "centre"
            )
        for insert in self.inserts:
            if abs(insert.centre_m(self.width_m) - 0.5 * self.width_m) > 1e-9:
                raise ValueError(
                    f"position of the {insert.kind} is {insert.position_m} m; in a round silo it must be the axis at "
                    f"{0.5 * self.width_m} m"
                )

    # --- what follows from it -------------------------------------------------------------------------------------

    @property
    def sinks(self) -> bool:
        """Whether the whole floor is the outlet, and the grid sinks with it."""
        return self.outlet is None and self.hopper is None and not self.inserts

    @property
    def outlet_m(self) -> tuple[float, float]:
        """Left and right edge of the opening of the floor."""
        wide = self.width_m
        if self.hopper is not None:
            return 0.5 * (wide - self.hopper.outlet_width_m), 0.5 * (wide + self.hopper.outlet_width_m)
        if self.outlet is None:
            return 0.0, wide
        b = self.outlet.width_m
        left = {"centre": 0.5 * (wide - b), "left": 0.0, "right": wide - b}[self.outlet.position]
        return left, left + b

    @property
    def outlet_share_m(self) -> float:
        """Area of the outlet as `area_m2` counts: its width, in a round silo d^2 / (4 R)."""
        left, right = self.outlet_m
        width = right - left
        return width**2 / (2.0 * self.width_m) if self.section == "round" else width

    @property
    def transition_m(self) -> float:
        """Height at which a hopper meets the vertical walls; 0 without."""
        if self.hopper is None:
            return 0.0
        tangent = math.tan(math.radians(self.hopper.half_angle_deg))
        return 0.5 * (self.width_m - self.hopper.outlet_width_m) / tangent

    def between(self, y):
        """X of the left and of the right wall at heights (array)."""
        high = self.transition_m
        part = np.clip((high - np.asarray(y, float)) / high, 0.0, 1.0) if high else np.zeros_like(np.asarray(y, float))
        left = part * self.outlet_m[0]
        return left, self.width_m - left

    def holds(self, x, y):
        """Whether places (arrays) hold sand when the silo is full."""
        left, right = self.between(y)
        inside = (x > left) & (x < right) & (y > 0.0) & (y < self.height_m)
        for insert in self.inserts:
            inside = inside & ~insert.contains(x, y, self.width_m)
        return inside

    def lattice(self, spacing_m: float):
        """x, y and area of the points that fill it, row after row from the floor.

        Rows fit between the walls: in a hopper points stand a little closer or farther apart than elsewhere.
        """
        rows = []
        for number in range(round(self.height_m / spacing_m)):
            y = (number + 0.5) * spacing_m
            left, right = self.between(y)
            pairs = 2 if self.section == "round" else 1  # the axis stands between two points
            count = max(1, round((right - left) / (pairs * spacing_m))) * pairs
            x = left + (np.arange(count) + 0.5) * (right - left) / count
            x = x[self.holds(x, y)]
            rows.append((x, np.full(len(x), y), np.full(len(x), spacing_m * (right - left) / count)))
        return tuple(np.concatenate(values) for values in zip(*rows, strict=True))

    def points(self, spacing_m: float) -> int:
        """How many those are."""
        return _count(self, spacing_m)

    @property
    def box_m2(self) -> float:
        """Width times height, or of a round silo what `area_m2` is of a cylinder."""
        return self.width_m * self.height_m * (0.5 if self.section == "round" else 1.0)

    @property
    def area_m2(self) -> float:
        """Of the section of the fill; of a round silo twice its content per radian over the radius."""
        cut = self.transition_m * self.outlet_m[0]  # of both wedges beside a hopper
        bodies = sum(insert.area_m2() for insert in self.inserts)
        if self.section == "plane":
            return self.width_m * self.height_m - cut - bodies
        return _round_area(self)

    def solids(self) -> list[np.ndarray]:
        """Outlines (n, 2) of hopper walls and inserts, for pictures [m]."""
        found = [insert.outline(self.width_m) for insert in self.inserts]
        if self.hopper is not None:
            wide, high, left = self.width_m, self.transition_m, self.outlet_m[0]
            found.append(np.array([[0.0, 0.0], [left, 0.0], [0.0, high]]))
            found.append(np.array([[wide, 0.0], [wide, high], [wide - left, 0.0]]))
        return found

    def words(self) -> str:
        """What is special about it, for titles; empty for a silo whose whole floor sinks."""
        found = []
        if self.section == "round":
            found.append("round silo")
        if self.outlet is not None:
            where = {"centre": "in the middle", "left": "at the left wall", "right": "at the right wall"}
            found.append(f"outlet of {1e3 * self.outlet.width_m:g} mm {where[self.outlet.position]}")
        if self.hopper is not None:
            found.append(f"hopper of {self.hopper.half_angle_deg:g}° with {1e3 * self.hopper.outlet_width_m:g} mm")
        found += [f"{insert.kind} of {1e3 * insert.width_m:g} mm" for insert in self.inserts]
        return ", ".join(found)


@lru_cache(maxsize=64)
def _count(silo: Silo, spacing_m: float) -> int:
    return len(silo.lattice(spacing_m)[0])


@lru_cache(maxsize=64)
def _round_area(silo: Silo, cells: int = 1000) -> float:
    """`Silo.area_m2` of a round silo, by a fine sum."""
    radius = 0.5 * silo.width_m
    x = (np.arange(cells) + 0.5) / cells * radius
    y = (np.arange(2 * cells) + 0.5) / (2 * cells) * silo.height_m
    x, y = np.meshgrid(x, y)
    return float(2.0 / radius * (x * silo.holds(radius + x, y)).mean() * radius * silo.height_m)
