"""The state from which a run can go on."""

import json
import time
from pathlib import Path

import numpy as np

from taichi_silo.observers import Observer


class Checkpoint(Observer):
    """`checkpoint.npz`: points, nodal memory, clock and scene, after filling, every few minutes and at the end.

    A state that is not finite never replaces a good one.
    """

    def __init__(self, file: Path, every_s: float = 120.0):
        self.file, self.every = file, every_s

    def begin(self, simulation) -> None:
        """Start the clock."""
        self.simulation = simulation
        self.due = time.monotonic() + self.every

    def observe(self, record) -> None:
        """Write when due."""
        if time.monotonic() > self.due:
            self.end()
            self.due = time.monotonic() + self.every

    def filled(self) -> None:
        """Write: the filling need not be done again."""
        self.end()

    def end(self) -> None:
        """Write, in one piece or not at all."""
        simulation = self.simulation
        state = {
            "time_s": simulation.time,
            "displacement_m": simulation.displacement,
            "stage": simulation.stage,
            "steps": simulation.steps,
            "flow_start_s": simulation.flow_start,
            "bottom_speed_m_per_s": simulation.bottom_speed,
            "settled": simulation.settled,
            "scene": simulation.scene.model_dump(),
        }
        arrays = simulation.particles.arrays()
        if not all(np.isfinite(array).all() for array in arrays.values()):
            return
        temporary = self.file.with_suffix(".part.npz")
        np.savez(
            temporary, header=json.dumps(state), grid_memory=simulation.solver.grid.memory.to_numpy(),
            **arrays,
        )  # fmt: skip
        temporary.replace(self.file)
