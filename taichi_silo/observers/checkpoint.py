"""The state from which a run can go on."""

import json
import time
from pathlib import Path

import numpy as np

from taichi_silo.observers import Observer


class Checkpoint(Observer):
    """`checkpoint.npz`: all that a run needs to go on, written every few minutes of work and at the end."""

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

    def end(self) -> None:
        """Write, in one piece or not at all."""
        simulation = self.simulation
        state = {
            "time_s": simulation.time,
            "displacement_m": simulation.displacement,
            "stage": simulation.stage,
            "steps": simulation.steps,
            "scene": simulation.scene.model_dump(),
        }
        temporary = self.file.with_suffix(".part.npz")
        np.savez(
            temporary, header=json.dumps(state), grid_memory=simulation.solver.grid.memory.to_numpy(),
            **simulation.particles.arrays(),
        )  # fmt: skip
        temporary.replace(self.file)
