"""The runs of a study of convergence: a scene on finer and finer cells, with shorter lengths, at several speeds.

Three numerical parameters bend a result: the size of the cells h; between very rough walls the length l of the
non-local law, which cannot act far below a cell, so that l = max(l_c, h / 2); and the speed v of the bottom, where the
scene's own would cost too much. Step k of the ladder has the run

    main k:   h_k, l_k = max(l_c, h_k / 2), v        and, from the second on,
    grid k:   h_k, l_{k-1}, v                        where the length of the step before is another one

so that main k-1 to grid k is the effect of the cells alone, and grid k to main k that of the length alone. The first
fine step also has runs at higher speeds.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

from taichi_silo.errors import BadInput
from taichi_silo.scene import cell_sizes
from taichi_silo.scene.averaging import OF_CELL
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation import outflow

FEWEST_ACROSS = 10  # cells across the silo, or a column that stands free, on the coarsest grid
FEWEST_IN_OPENING = 4  # cells across an outlet or the mouth of a hopper, likewise
FEWEST_IN_BODY = 2  # cells across an insert, likewise
FINER, LEAST_FINER, MOST_FINER = 1.6, 1.3, 2.2  # ratio of the cells of a step to those of the next, as ASME V&V 20 asks
MOST_ACROSS = 2000  # cells
SLOW = 6e-3  # v / sqrt(g b) below which the bottom may run: 8 mm/s in a silo of 0.2 m (inertia scales masses, too)
FASTER = 2.0  # ratio of speeds
SPEEDS = 3  # of the bottom, where they count
SPEED_STEP = 1  # of the ladder, at which the bottom has several speeds


@dataclass(frozen=True)
class Rung:
    """Cell size [m], length of the law [m] and speed of the bottom [m/s] of one run."""

    cell_m: float
    length_m: float
    speed_m_per_s: float

    @property
    def name(self) -> str:
        """Of its folder."""
        cell, length = 1e3 * self.cell_m, 1e3 * self.length_m
        return f"cell-{cell:.4g}mm_length-{length:.4g}mm_speed-{1e3 * self.speed_m_per_s:.4g}mm-per-s"


@dataclass(frozen=True)
class Ladder:
    """The ladder of a scene, as long as it is wanted.

    Raises BadInput if no two cell sizes divide the scene.
    """

    scene: Scene
    _cells: list[float] = field(default_factory=list, init=False, repr=False, compare=False)

    def __post_init__(self):
        self.cell(1)

    @cached_property
    def aim_m(self) -> float:
        """Length of the scene's own law [m]."""
        return self.scene.averaging.length_m(self.scene.sand)

    @cached_property
    def speed_m_per_s(self) -> float:
        """Speed of the bottom in the main runs: the scene's own, doubled as often as sand still follows slowly.

        Also the highest speed must be reached long before the end.
        """
        own, flow, method = self.scene.flow.speed_m_per_s, self.scene.flow, self.scene.method
        slow = SLOW * math.sqrt(method.gravity_m_per_s2 * self.scene.silo.width_m / method.mass_scaling)
        most = min(slow, outflow.reached_m_per_s(self.scene) / FASTER ** (SPEEDS - 1))
        if flow.free or own >= most:
            return own
        return own * FASTER ** math.floor(math.log(most / own, FASTER) + 1e-9)

    @cached_property
    def speeds(self) -> list[float]:
        """Falling speeds of the bottom, the last that of the main runs; one if that is the scene's own."""
        slowest = self.speed_m_per_s
        count = SPEEDS if slowest > self.scene.flow.speed_m_per_s else 1
        return [slowest * FASTER**number for number in reversed(range(count))]

    def cell(self, step: int) -> float:
        """Size of the cells of a step [m]."""
        while len(self._cells) <= step:
            self._cells.append(self._next(self._cells[-1] if self._cells else None))
        return self._cells[step]

    def length(self, step: int) -> float:
        """Length of the law in the main run of a step [m]."""
        return max(self.aim_m, OF_CELL * self.cell(step)) if self.scene.sticks else self.aim_m

    def main(self, step: int) -> Rung:
        """The main run of a step."""
        return Rung(self.cell(step), self.length(step), self.speed_m_per_s)

    def grid(self, step: int) -> Rung:
        """The run with the cells of a step and the length of the one before."""
        return Rung(self.cell(step), self.length(step - 1), self.speed_m_per_s)

    def faster(self) -> list[Rung]:
        """The runs of all speeds."""
        return [Rung(self.cell(SPEED_STEP), self.length(SPEED_STEP), speed) for speed in self.speeds]

    def step(self, step: int) -> dict[str, Rung]:
        """The runs of a step, each once, by their names."""
        rungs = [self.main(step)]
        if step > 0:
            rungs.append(self.grid(step))
        if step == SPEED_STEP:
            rungs += self.faster()
        return {rung.name: rung for rung in rungs}

    def made(self, rung: Rung) -> Scene:
        """The scene of a run."""
        return changed(self.scene, self._values(rung))

    def _values(self, rung: Rung) -> dict:
        return {
            "grid.cell_size_m": rung.cell_m,
            "averaging.characteristic_length_m": rung.length_m,
            "flow.speed_m_per_s": rung.speed_m_per_s, "machine.threads": 1,
        }  # fmt: skip

    def _next(self, before: float | None) -> float:
        """The cell size that follows another one, or the coarsest."""
        silo = self.scene.silo
        if before is None:
            found = cell_sizes.coarsest(silo, self._fewest_across(), MOST_ACROSS)
        else:
            sizes = cell_sizes.dividing(silo, MOST_ACROSS)
            finer = before / sizes
            fitting = cell_sizes.squares(silo, sizes[(finer >= LEAST_FINER) & (finer <= MOST_FINER)])
            fitting = fitting if len(fitting) else sizes[finer > MOST_FINER][:1]
            found = min(fitting, key=lambda size: abs(math.log(size * FINER / before)), default=None)
        if found is None:
            than = "" if before is None else f" that are finer than {before:.3g} m"
            raise BadInput(f"width is {silo.width_m:g} m; no cells fit it and what is in the silo{than}")
        return cell_sizes.short(silo, float(found))

    def _fewest_across(self) -> int:
        """Cells across that the coarsest grid needs, for the smallest thing in the scene."""
        silo = self.scene.silo
        wanted = [FEWEST_ACROSS, FEWEST_IN_OPENING * silo.width_m / cell_sizes.opening_m(silo)]
        if silo.column_m is not None:
            wanted.append(FEWEST_ACROSS * silo.width_m / (silo.column_m[1] - silo.column_m[0]))
        for insert in silo.inserts:
            corners = insert.outline(silo.width_m)
            wanted.append(FEWEST_IN_BODY * silo.width_m / float((corners.max(axis=0) - corners.min(axis=0)).min()))
        return math.ceil(max(wanted) - 1e-9)
