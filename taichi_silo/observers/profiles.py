"""Wall stresses against height in the paper's three states: `walls.csv`."""

import csv
from pathlib import Path

import numpy as np

from taichi_silo.grid import MARGIN
from taichi_silo.observers import Observer
from taichi_silo.placing import BOTTOM, LEFT, RIGHT

BLOCK_PERIODS = 5  # of the column, whose mean makes a flow profile


class WallProfiles(Observer):
    """Means of the nodal wall forces at the end of filling, at the greatest wall force, and at the end of flow."""

    def __init__(self, file: Path):
        self.file = file

    def begin(self, simulation) -> None:
        """Start with no state."""
        self.simulation = simulation
        self.period = simulation.rows_per_period
        self.full = BLOCK_PERIODS * self.period
        self.states: dict[str, tuple[float, np.ndarray]] = {}  # state: bottom displacement, profile
        self.block, self.largest = [], 0.0

    def observe(self, record) -> None:
        """Gather blocks of records."""
        if self.block and self.block[-1].stage != record.stage:
            self._close(self.period)
        self.block.append(record)
        if record.stage == "flow" and len(self.block) == self.full:
            self._close(self.full)

    def _close(self, count: int) -> None:
        recent = self.block[-count:]
        span = sum(r.interval_s for r in recent)
        mean = sum(r.profile * r.interval_s for r in recent) / span
        normal = sum(r.normal_N_per_m * r.interval_s for r in recent) / span
        here = (recent[-1].displacement_m, mean)
        if recent[-1].stage == "filling":
            self.states["filling"] = here
        else:
            self.states["residual"] = here
            if normal > self.largest:
                self.largest, self.states["maximum"] = normal, here
        self.block = []

    def end(self) -> None:
        """Write the file."""
        if self.block and (self.block[-1].stage == "filling" or "residual" not in self.states):
            self._close(self.period)
        with open(self.file, "w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(["state", "wall", "height_m", "normal_stress_Pa", "shear_stress_Pa"])
            for state in ("filling", "maximum", "residual"):
                if state in self.states:
                    self._write(writer, state, *self.states[state])

    def _write(self, writer, state: str, displacement: float, profile: np.ndarray) -> None:
        h, grid = self.simulation.scene.grid.cell_size_m, self.simulation.solver.grid
        sides = ((LEFT, "left", grid.rows, -displacement), (RIGHT, "right", grid.rows, -displacement))
        for wall, name, slots, origin in (*sides, (BOTTOM, "bottom", self.simulation.columns, 0.0)):
            coordinate, stress = wall_stress(profile[wall, :slots], h, closed=name == "bottom")
            normal, shear = (stress[:, 0], stress[:, 1]) if name != "bottom" else (stress[:, 1], stress[:, 0])
            normal = -normal if name == "right" else normal
            for place, n, t in zip(coordinate + origin, normal, shear, strict=True):
                writer.writerow([state, name, f"{place:.6g}", f"{n:.6g}", f"{t:.6g}"])


def wall_stress(force: np.ndarray, cell_size_m: float, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (n) and stresses (n, 2) [Pa] along a wall from its nodal forces (slots, 2) [N/m].

    Nodes beyond the corner belong to the corner node, whose share of the wall is half a cell. `closed` says that
    the wall ends in a corner at its far side as well; else it ends at the sand's free surface.
    """
    force = force.copy()
    force[MARGIN] += force[:MARGIN].sum(axis=0)
    share = np.full(len(force), cell_size_m)
    share[MARGIN] = 0.5 * cell_size_m
    last = len(force) - 1
    if closed:
        last = len(force) - 1 - MARGIN
        force[last] += force[last + 1 :].sum(axis=0)
        share[last] = 0.5 * cell_size_m
    chosen = slice(MARGIN, last + 1)
    return (np.arange(len(force))[chosen] - MARGIN) * cell_size_m, force[chosen] / share[chosen, None]
