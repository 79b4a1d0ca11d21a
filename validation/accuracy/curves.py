"""The curves by which runs are compared: forces over the bottom displacement, wall stress over height."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.wall_pressure import CELL_M, CORNER_M, SURFACE, cell_mean
from taichi_silo.runs.observers import Observer
from taichi_silo.runs.observers.wall_profiles import wall_stress
from taichi_silo.simulation.wall_forces import LEFT, RIGHT, normal_and_shear

BINS = 100  # of the whole displacement
FIRST_BIN = 2  # the bottom goes through the first two in about one period of the column: waves, not yet forces of flow
RESIDUAL_FROM = 0.8  # of the displacement: the window of residual forces and of the wall profile
FINE_M, SPACING_M = 0.0025, 0.01  # of heights: while smoothing, and kept


@dataclass(frozen=True)
class Curves:
    """Means of P, T and N [N/m] over equal parts of the bottom displacement [m] (their middles)."""

    displacement_m: np.ndarray
    P: np.ndarray
    T: np.ndarray
    N: np.ndarray

    @classmethod
    def of(cls, flow: pd.DataFrame, displacement_m: float) -> "Curves":
        """Means over equal parts of the displacement from the records of the flow; no impulse is lost between them.

        Impulse and time are interpolated at the edges of the parts; a mean is their quotient. The first two of a
        hundred parts are left out.
        """
        edges = np.linspace(FIRST_BIN / BINS, 1.0, BINS - FIRST_BIN + 1) * displacement_m
        travel = np.concatenate([[0.0], flow.displacement_m])

        def at_edges(rate) -> np.ndarray:
            return np.interp(edges, travel, np.concatenate([[0.0], np.cumsum(rate * flow.interval_s)]))

        seconds = np.diff(at_edges(np.ones(len(flow))))
        names = {"P": "bottom_force_N_per_m", "T": "shear_N_per_m", "N": "normal_N_per_m"}
        forces = {name: np.diff(at_edges(flow[column])) / seconds for name, column in names.items()}
        return cls(displacement_m=0.5 * (edges[1:] + edges[:-1]), **forces)

    def residual(self) -> dict[str, float]:
        """Means over the last fifth of the displacement [N/m]."""
        last = self.displacement_m >= RESIDUAL_FROM * self.displacement_m[-1]
        return {name: float(getattr(self, name)[last].mean()) for name in ("P", "T", "N")}


class WallProfile(Observer):
    """Mean of both walls' normal stress over the last fifth of the displacement."""

    def begin(self, simulation) -> None:
        """Start with nothing."""
        self.simulation, self.impulse, self.seconds = simulation, 0.0, 0.0

    def observe(self, record) -> None:
        """Add up the nodal impulses."""
        scene = self.simulation.scene
        if record.stage == "flow" and record.displacement_m >= RESIDUAL_FROM * scene.flow.displacement_m:
            self.impulse = self.impulse + record.profile * record.interval_s
            self.seconds += record.interval_s

    def smooth(self) -> dict[str, np.ndarray]:
        """Wall stress as a pressure cell reads it, every 10 mm above the plate; without corner and surface."""
        scene, rows = self.simulation.scene, self.simulation.solver.grid.rows
        nodes, sides = None, []
        for row, wall in ((LEFT, "left"), (RIGHT, "right")):
            force = self.impulse[row, :rows] / self.seconds
            nodes, stress = wall_stress(force, scene.grid.cell_size_m, closed=False)
            sides.append(normal_and_shear(wall, stress)[0])
        fine = np.arange(0.0, scene.silo.height_m, FINE_M)
        read = cell_mean(fine, np.interp(fine, nodes, np.mean(sides, axis=0)), CELL_M)
        height = np.arange(CORNER_M + 0.5 * CELL_M, SURFACE * scene.silo.height_m, SPACING_M)
        return {"height_m": height, "normal_stress_Pa": np.interp(height, fine, read)}
