"""Outlets of a silo that a user gives: openings of the floor or of a side wall, each with a gate of its own."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from taichi_silo.utils.schema import TABLE, TABLES, Options

MOST_OUTLETS = 20


class Outlet(Options):
    """An opening of the flat floor or of a side wall, with a gate; without one the whole floor is the outlet."""

    width_m: float = Field(
        ge=1e-4, le=1000, description="width of the opening, in a side wall its height; its edges lie on grid lines"
    )
    position: Literal["centre", "left", "right"] | float = Field(
        "centre", description="where in the floor: in its middle, beside a wall, or x of the middle of the opening; in "
        "a side wall y of its middle [m]",
    )  # fmt: skip
    wall: Literal["floor", "left", "right"] = Field("floor", description="what it is an opening of")
    opens_at_s: float = Field(0.0, ge=0, le=1e6, description="when its gate opens, after the outflow has begun")
    closes_at_s: float | None = Field(
        None, gt=0, le=1e6, description="when its gate begins to close, after the outflow has begun; never if absent"
    )

    @model_validator(mode="after")
    def _possible(self):
        if self.wall != "floor" and not isinstance(self.position, float):
            raise ValueError(
                f"outlet position is {self.position}; of an outlet in the {self.wall} wall it must be the height of "
                "its middle [m]"
            )
        if self.closes_at_s is not None and self.closes_at_s <= self.opens_at_s:
            raise ValueError(
                f"outlet closes_at_s is {self.closes_at_s:g} s; it must be above opens_at_s of {self.opens_at_s:g} s"
            )
        return self

    @property
    def timed(self) -> bool:
        """Whether its gate does not just open with the outflow."""
        return self.opens_at_s > 0.0 or self.closes_at_s is not None

    def words(self) -> str:
        """Its width and place, as titles of figures name them."""
        place, size = self.position, f"outlet of {1e3 * self.width_m:g} mm"
        if self.wall != "floor":
            return f"{size} in the {self.wall} wall at y = {1e3 * float(place):g} mm"
        if isinstance(place, float):
            return f"{size} at x = {1e3 * place:g} mm"
        return f"{size} " + {"centre": "in the middle", "left": "at the left wall", "right": "at the right wall"}[place]


def _kind(given: Any) -> str:
    return TABLES if isinstance(given, list | tuple) else TABLE


Several = Annotated[tuple[Outlet, ...], Field(max_length=MOST_OUTLETS)]
# one table, or an array of them
OneOrSeveral = Annotated[Annotated[Outlet, Tag(TABLE)] | Annotated[Several, Tag(TABLES)], Discriminator(_kind)]


@dataclass(frozen=True)
class Opening:
    """Where sand leaves.

    Attributes
    ----------
    wall : "floor", "left" or "right".
    low, high : its edges, along x in the floor, else along y [m].
    at_m : y of the floor, or x of the wall [m].
    opens_s, closes_s : of its gate, after the outflow has begun [s]; None: never.

    """

    wall: str
    low: float
    high: float
    at_m: float = 0.0
    opens_s: float = 0.0
    closes_s: float | None = None

    @property
    def width(self) -> float:
        """Between its edges [m]."""
        return self.high - self.low

    @property
    def in_floor(self) -> bool:
        """Whether sand falls through it."""
        return self.wall == "floor"

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Both edges (x, y) [m]."""
        if self.in_floor:
            return (self.low, self.at_m), (self.high, self.at_m)
        return (self.at_m, self.low), (self.at_m, self.high)

    @property
    def outwards(self) -> tuple[float, float]:
        """Unit vector (x, y) out of the silo."""
        return {"floor": (0.0, -1.0), "left": (-1.0, 0.0), "right": (1.0, 0.0)}[self.wall]

    def shifted(self, shift_m: float) -> "Opening":
        """The same in a frame that begins so far to the right."""
        if self.in_floor:
            return replace(self, low=self.low - shift_m, high=self.high - shift_m)
        return replace(self, at_m=self.at_m - shift_m)

    def box(self, near_m: float, far_m: float, beside_m: float = 0.0) -> tuple[float, float, float, float]:
        """Left, low, right, high [m] of what lies between two distances beyond it, and so far beside its edges."""
        (x, y), low, high = self.outwards, self.low - beside_m, self.high + beside_m
        near, far = sorted(self.at_m + (x + y) * distance for distance in (near_m, far_m))
        return (low, near, high, far) if self.in_floor else (near, low, far, high)


def mirrored(openings: Iterable[Opening], wide_m: float) -> bool:
    """Whether openings are their own mirror image about half the width."""
    other = {"floor": "floor", "left": "right", "right": "left"}
    here = {_rounded(one.wall, one.low, one.high, one) for one in openings}
    there = {
        _rounded(
            other[one.wall], *((wide_m - one.high, wide_m - one.low) if one.in_floor else (one.low, one.high)), one
        )
        for one in openings
    }
    return here == there


def _rounded(wall: str, low: float, high: float, one: Opening) -> tuple:
    return wall, round(low, 8), round(high, 8), one.opens_s, one.closes_s
