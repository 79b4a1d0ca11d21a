"""What a run has left of its course: its scene, its forces, and the states of its points over time."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.run_folder import MADE
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.utils import bounded_reading

WORDS = ("file", "stage")  # columns without numbers


@dataclass(frozen=True)
class History:
    """The course of one run, also of one that goes on or ended early.

    Attributes
    ----------
    folder : of the run.
    scene : what was simulated.
    index : rows of `snapshots/index.csv` whose files are there, by time, one for each time.
    forces : rows of `forces.csv` with `P`, `T` and `N` [N/m], T and N the means of both walls.

    """

    folder: Path
    scene: Scene
    index: pd.DataFrame
    forces: pd.DataFrame

    @classmethod
    def read(cls, folder: Path) -> "History":
        """Read the small files of a run; states are read when they are asked for.

        Raises
        ------
        BadInput
            if the folder holds no run of a silo, or one without snapshots.

        """
        folder = bounded_reading.place(folder, "folder")
        if not (folder / MADE).is_file():
            raise BadInput(f"folder is {folder}; it must be that of a run, with {MADE} in it")
        index = _table(folder / "snapshots" / "index.csv", ["file", "stage", "time_s", "displacement_m"])
        there = [file == Path(file).name and (folder / "snapshots" / file).is_file() for file in index["file"]]
        index = index[np.array(there, bool)].sort_values("time_s", kind="stable").drop_duplicates("time_s", keep="last")
        if index.empty:
            raise BadInput(f"folder {folder} has no snapshots; it must be that of a run that has begun")
        if "filling" not in index["stage"].to_list():
            raise BadInput(f"folder {folder} has no snapshot of the filling; it must be that of a run")
        sides = [f"{side}_{part}_N_per_m" for part in ("shear", "normal") for side in ("left", "right")]
        forces = _table(folder / "forces.csv", ["stage", "time_s", "displacement_m", "bottom_force_N_per_m", *sides])
        means = {name: forces[sides[k : k + 2]].mean(axis=1) for name, k in (("T", 0), ("N", 2))}
        forces = forces.assign(P=forces["bottom_force_N_per_m"], **means)
        return cls(folder, read_scene(folder / MADE, threads=1), index.reset_index(drop=True), forces)

    def state(self, number: int) -> dict[str, np.ndarray]:
        """The points of a row of the index, as `Simulation.points` gives them."""
        return snapshot.read(self.folder / "snapshots" / self.index["file"].iloc[number])

    @cached_property
    def start(self) -> dict[str, np.ndarray]:
        """The points of the fill before anything has happened to them."""
        return self.state(0)

    @property
    def free(self) -> bool:
        """Whether the sand falls out by its weight."""
        return self.scene.flow.outflow == "gravity"

    @cached_property
    def flow(self) -> np.ndarray:
        """Numbers of the rows of the index that belong to the flow."""
        return np.flatnonzero(self.index["stage"] == "flow")

    @cached_property
    def flow_start_s(self) -> float:
        """When the filling was over, or as far as it came."""
        return float(self.index["time_s"][self.index["stage"] == "filling"].iloc[-1])

    @property
    def end_s(self) -> float:
        """Of the last state."""
        return float(self.index["time_s"].iloc[-1])

    def progress(self, row) -> float:
        """Place of a row of the index or of `forces` on the course: displacement [m], or where free time of flow."""
        if row["stage"] != "flow":
            return 0.0
        return float(row["time_s"] - self.flow_start_s if self.free else row["displacement_m"])


def _table(file: Path, columns: list[str]) -> pd.DataFrame:
    """A table, its whole rows only; empty if the file is not there."""
    found = bounded_reading.frame(file) if file.exists() else pd.DataFrame()
    if not len(found.columns):
        return pd.DataFrame(columns=columns)
    lacking = [name for name in columns if name not in found]
    if lacking:
        raise BadInput(f"file {file} has no column {lacking[0]}; it must be that of a run")
    for name in columns:
        found[name] = found[name].astype(str) if name in WORDS else bounded_reading.numbers(found[name])
    return found.dropna(subset=columns)
