"""The points of a simulation as others see them: of the whole silo, in the laboratory."""

from collections.abc import Collection, Iterator

import numpy as np

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.point_sums import BELOW
from taichi_silo.mpm.solver import Solver
from taichi_silo.simulation.alarm import Alarm
from taichi_silo.simulation.clock import Clock
from taichi_silo.simulation.model import Model

PIECE = 1 << 16  # points whose fields are handed out at once


class Views:
    """The part of a `Simulation` that knows its points."""

    model: Model
    solver: Solver
    clock: Clock
    identity: np.ndarray

    @property
    def origin_m(self) -> float:
        """Height of the grid's origin in the laboratory [m]."""
        return -self.clock.displacement if self.model.scene.silo.floor_is_outlet else 0.0

    def points(self, *names: str) -> dict[str, np.ndarray]:
        """Fields of the points of the whole silo as arrays: all, or those named.

        `position` is in the laboratory; `void_ratio`; `identity`, by which a point is found again in another state.
        Masses and volumes are per metre run, in a round silo of the point's own girth.
        """
        self.solver.executor.rest()  # so that there is room for what is done with them
        return self._whole(names or self.names_of_points, 0, self.model.particles.number)

    def pieces(self, name: str) -> Iterator[np.ndarray]:
        """A field of `points`, some rows after the others, so that it is never there as a whole."""
        self.solver.executor.rest()
        sides, count = self.model.section.points_per_computed, self.model.particles.number
        for side in range(sides):
            for first in range(0, max(count, 1), PIECE):
                rows = self._whole((name,), first, min(first + PIECE, count))[name]
                length = len(rows) // sides
                yield rows[side * length : (side + 1) * length]

    @property
    def names_of_points(self) -> tuple[str, ...]:
        """Of the fields that `points` gives."""
        return (*self.model.particles.names, "void_ratio", "identity")

    def _whole(self, names: tuple[str, ...], first: int, end: int) -> dict[str, np.ndarray]:
        """Fields of computed points `first` to `end`, and of those that they stand for."""
        asked = {*names, "position"} if self.model.section.round else names
        whole = self.model.section.whole(self._computed(asked, first, end), self.model.scene.silo.width_m)
        return {name: whole[name] for name in names}

    def inside(self, points: dict[str, np.ndarray]) -> np.ndarray:
        """Which of `points()` are finite and within the grid less its margin."""
        return self._within(points, self.model.scene.silo.width_m)

    def _computed(self, names: Collection[str], first: int = 0, end: int | None = None) -> dict[str, np.ndarray]:
        """Fields of the computed points, or of those of numbers `first` to `end`; heights are as in `points`."""
        particles = self.model.particles
        arrays = {name: particles.array(name, first, end) for name in names if name in particles.names}
        if "position" in arrays:
            arrays["position"] += (0.0, self.origin_m)
        if "void_ratio" in names:
            volume, mass = (particles.array(name, first, end) for name in ("volume", "mass"))
            arrays["void_ratio"] = volume * self.model.law.grain_density / mass - 1.0
        if "identity" in names:
            arrays["identity"] = self.identity[first:end]
        return arrays

    def _within(self, points: dict[str, np.ndarray], width_m: float) -> np.ndarray:
        grid = self.model.grid
        place = points["position"] - np.array([0.0, self.origin_m])
        beside = (BELOW if grid.open_sides else 1.0) * grid.cell_size
        low = np.array([-beside, -grid.first_cell_height])
        top = np.array([width_m + beside, (grid.rows - 2 * MARGIN) * grid.first_cell_height])
        return ((place > low) & (place < top)).all(axis=1) & np.isfinite(points["stress"]).all(axis=1)

    def _astray(self, count: int) -> Alarm:
        """The alarm of points that are outside the grid or not finite, at the first of them."""
        points, section = self._computed(("position", "stress")), self.model.section
        first = int(np.argmin(self._within(points, section.width)))
        place, point = points["position"][first], self.identity[first]
        lost = int((~np.isfinite(points["stress"]).all(axis=1) | ~np.isfinite(points["position"]).all(axis=1)).sum())
        if not np.isfinite(place).all():  # where it is cannot be said, but where it was filled in
            place = self.model.fill()["position"][point]
        alarm = Alarm(
            "not finite" if lost else "outside the grid", True,
            f"{count} points left the silo or are not finite, one{{place}}",
            f"a time step too large is the likely cause (it was {1e6 * self.clock.step:.1f} us)",
            "let the step be chosen, or give a smaller cfl", float(count), 0.0,
        )  # fmt: skip
        return alarm.at(place + (section.shift, 0.0), point)
