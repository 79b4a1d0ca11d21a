"""The paper's silo flows, sections 6 and 7, by name: sand, walls, outlet, and what drives the sand."""

from dataclasses import dataclass

from taichi_silo.cli.model_silo import SMOOTH_ANGLE_DEG

VOID_RATIO = {"dense": 0.60, "loose": 0.90}
WALLS = ("smooth", "very-rough")


@dataclass(frozen=True)
class Opening:
    """The part of the floor that sinks: from `left_m` over `width_m`, counted from the left wall [m]."""

    left_m: float
    width_m: float
    silo_width_m: float = 0.2

    @property
    def whole(self) -> bool:
        """Whether it is the whole bottom (section 6)."""
        return self.width_m >= self.silo_width_m

    @property
    def right_m(self) -> float:
        """Right end [m]."""
        return self.left_m + self.width_m

    @property
    def symmetric(self) -> bool:
        """Whether it lies in the middle."""
        return abs(self.left_m + self.right_m - self.silo_width_m) < 1e-9


OUTLETS = {
    "bottom": Opening(0.0, 0.2),  # section 6
    "centre-80": Opening(0.06, 0.08),  # section 7, case 1
    "right-150": Opening(0.05, 0.15),  # section 7, case 2: next to the right wall
    "right-50": Opening(0.15, 0.05),
}


@dataclass(frozen=True)
class Case:
    """One flow of the paper.

    Attributes
    ----------
    name : `{dense|loose}_{smooth|very-rough}_{outlet}`, with `gravity_` before it where the sand falls freely.
    sand, walls, outlet : words of the name.
    gravity : whether the outlet is open and gravity alone drives the sand. Else the sand leaves through it at a
        prescribed speed while floor and grid stand still, and what is below the floor (y < 0) is taken away; with the
        outlet `bottom` the whole floor sinks.
    silo_width_m, silo_height_m, displacement_m : of the silo, and how far the bottom or the outlet sinks [m].

    """

    name: str
    sand: str
    walls: str
    outlet: str
    gravity: bool = False
    silo_width_m: float = 0.2
    silo_height_m: float = 0.5
    displacement_m: float = 0.02

    @property
    def void_ratio(self) -> float:
        """Initial void ratio [-]."""
        return VOID_RATIO[self.sand]

    @property
    def wall_friction_angle_deg(self) -> float | None:
        """Friction angle of smooth walls [degrees]; None at very rough ones."""
        return SMOOTH_ANGLE_DEG[self.sand] if self.walls == "smooth" else None

    @property
    def opening(self) -> Opening:
        """Where the sand leaves."""
        return OUTLETS[self.outlet]

    @property
    def section(self) -> str:
        """Section of the paper: 6 for the whole bottom, 7 for outlets."""
        return "6" if self.opening.whole else "7"

    @property
    def words(self) -> str:
        """The case in words, for titles."""
        outlet = {"bottom": "whole bottom", "centre-80": "outlet of 80 mm in the middle"}.get(self.outlet)
        outlet = outlet or f"outlet of {1e3 * self.opening.width_m:g} mm at the right wall"
        driven = ", emptied by gravity" if self.gravity else ""
        return f"{self.sand} sand, {self.walls.replace('-', ' ')} walls, {outlet}{driven}"


def _all() -> dict[str, Case]:
    """All 17 by name: four mass flows, twelve controlled outflows, one free outflow."""
    found = {}
    for outlet in OUTLETS:
        for sand in VOID_RATIO:
            for walls in WALLS:
                name = f"{sand}_{walls}_{outlet}"
                found[name] = Case(name, sand, walls, outlet)
    name = "gravity_dense_very-rough_centre-80"
    found[name] = Case(name, "dense", "very-rough", "centre-80", gravity=True)
    return found


CASES = _all()
