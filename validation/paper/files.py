"""One run's folder, read piece by piece and only once."""

import json
import tomllib
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.wall_pressure import CELL_M, CORNER_M, SURFACE, cell_mean
from taichi_silo.errors import RunFailed
from taichi_silo.runs.snapshot import figured
from taichi_silo.utils import vtu
from validation.paper.cases import CASES, Case

PERIOD = 10  # rows of forces.csv in one period of the column, over which forces are averaged
FORCES = {"P": "bottom_force_N_per_m", "angle": "wall_friction_angle_deg"}


class Missing(RunFailed):
    """A run that is not there, or has not ended."""


class Damaged(RunFailed):
    """A run that failed, or whose files cannot be read."""


class Points:
    """A snapshot: place (n, 2) [m] in the laboratory, void ratio, velocity (n, 2), volume, strain path."""

    def __init__(self, file: Path):
        places, arrays = vtu.read(file)
        self.position = places[:, :2]
        names = ("velocity", "void_ratio", "volume_m2_per_m", "strain_path")
        velocity, self.void_ratio, self.volume, self.path = (arrays[name].astype(float) for name in names)
        self.velocity = velocity[:, :2]
        self.count = len(self.position)


class RunFiles:
    """The files of one run, read when they are asked for.

    Parameters
    ----------
    folder : of the run; its name tells the case (else give the case).
    case : what was run.
    """

    def __init__(self, folder: Path, case: Case | None = None):
        self.folder = Path(folder)
        self.case = case or CASES[self.folder.name]
        self._snapshots: dict[str, Points] = {}

    def check(self, failed: bool = False) -> None:
        """Refuse a run that is not there, has not ended, or, unless such runs are wanted as well, failed."""
        if not self.folder.is_dir():
            raise Missing(f"{self.case.name} has not been run")
        if not (self.folder / "summary.json").exists():
            raise Missing(f"{self.case.name} has not ended")
        if not self.summary.get("finished", False) and not failed:
            raise Damaged(f"{self.case.name} went wrong: {self.summary.get('failure') or 'no reason is told'}")

    def _read(self, name: str, reader):
        """What a reader makes of a file."""
        try:
            return reader(self.folder / name)
        except FileNotFoundError as error:
            raise Damaged(f"folder {self.case.name} is damaged: {name} is missing") from error
        except Exception as error:  # whatever a broken file makes of a parser, XML included
            raise Damaged(f"folder {self.case.name} is damaged: {name} cannot be read") from error

    @cached_property
    def summary(self) -> dict:
        """`summary.json`."""
        return self._read("summary.json", lambda file: dict(json.loads(file.read_text())))

    @cached_property
    def parameters(self) -> dict:
        """`run.toml`."""
        return self._read("run.toml", lambda file: tomllib.loads(file.read_text()))

    @cached_property
    def forces(self) -> pd.DataFrame:
        """`forces.csv` with P, T and N [N/m] (T and N the mean of both walls) and angle [degrees]."""

        def read(file):
            table = pd.read_csv(file)
            for name, part in (("N", "normal"), ("T", "shear")):
                table[name] = 0.5 * (table[f"left_{part}_N_per_m"] + table[f"right_{part}_N_per_m"])
            table = table.rename(columns={column: name for name, column in FORCES.items()})
            return table.assign(displacement_m=table.displacement_m.astype(float))

        return self._read("forces.csv", read)

    @cached_property
    def filled(self) -> pd.Series:
        """Mean of the last period of filling."""
        rows = self.forces[self.forces.stage == "filling"].tail(PERIOD)
        return self._some(rows, "filling").mean(numeric_only=True)

    @cached_property
    def flow(self) -> pd.DataFrame:
        """Rows of flow, as means over one period."""
        rows = self.forces[self.forces.stage == "flow"]
        few = min(PERIOD, max(len(rows), 1))
        means = rows.select_dtypes("number").rolling(few, center=True, min_periods=few).mean()
        return self._some(means.dropna(subset=["P", "N", "T"]), "flow")

    def _some(self, rows, stage):
        if rows.empty:
            raise Damaged(f"folder {self.case.name} is damaged: forces.csv has no row of {stage}")
        return rows

    @cached_property
    def progress(self) -> np.ndarray:
        """Of each row of flow, 0 to 1: by displacement, or by time where none is prescribed."""
        for name in ("displacement_m", "time_s"):
            passed = self.flow[name].to_numpy()
            if passed[-1] > passed[0]:
                break
        else:
            return np.ones(len(passed))
        begin = 0.0 if name == "displacement_m" else passed[0]
        return (passed - begin) / (passed[-1] - begin)

    def mean(self, name: str, begin: float, end: float) -> float:
        """Mean of a force in a part of flow, `begin` to `end` between 0 and 1."""
        chosen = (self.progress >= begin) & (self.progress <= end)
        return float(self.flow[name][chosen].mean())

    @cached_property
    def outlet_speed(self) -> float:
        """At which bottom or outlet sink [m/s]; nan where gravity drives."""
        rows = self.forces[self.forces.stage == "flow"]
        span = rows.time_s.iloc[-1] - rows.time_s.iloc[0] if len(rows) else 0.0
        speed = (rows.displacement_m.iloc[-1] - rows.displacement_m.iloc[0]) / span if span > 0.0 else 0.0
        return float(speed) if speed > 0.0 else np.nan

    @cached_property
    def walls(self) -> pd.DataFrame:
        """`walls.csv`."""
        return self._read("walls.csv", lambda file: pd.read_csv(file).astype({"height_m": float}))

    def profile(self, state: str, wall: str, stress: str = "normal", reading: str = "node"):
        """Height above the bottom, also a sunk one, [m] and stress [Pa] along a wall, less the corner and the top.

        Parameters
        ----------
        state : "filling", "maximum" or "residual".
        wall : "left", "right", or "both" for the mean of the two.
        stress : "normal" or "shear".
        reading : "node", or "cell" for the mean over the height of a pressure cell.
        """
        if wall == "both":
            (height, left), right = (self.profile(state, side, stress, reading) for side in ("left", "right"))
            return height, 0.5 * (left + np.interp(height, *right))
        walls = self.walls
        rows = walls[(walls.state == state) & (walls.wall == wall)].sort_values("height_m")
        if len(rows) < 5:
            raise Damaged(f"folder {self.case.name} is damaged: walls.csv lacks the {wall} wall, {state}")
        height, value = rows.height_m.to_numpy() - rows.height_m.iloc[0], rows[f"{stress}_stress_Pa"].to_numpy(float)
        clear = CORNER_M
        if reading == "cell":
            value, clear = cell_mean(height, value), clear + 0.5 * CELL_M
        chosen = (height > clear) & (height < SURFACE * self.case.silo_height_m) & np.isfinite(value)
        return height[chosen], value[chosen]

    @cached_property
    def index(self) -> pd.DataFrame:
        """`snapshots/index.csv`, less the snapshots that only films need."""
        return self._read("snapshots/index.csv", lambda file: figured(pd.read_csv(file)))

    def points(self, when: str) -> Points:
        """Snapshot "filled", "first" (of flow), "before" (the last but one), or "last"."""
        flow = list(self.index.file[(self.index.stage == "flow") & (self.index.file != "filled.vtu")])
        place = {"first": 0, "before": -2, "last": -1}
        if when != "filled" and len(flow) < (2 if when == "before" else 1):
            raise Damaged(f"folder {self.case.name} is damaged: there are {len(flow)} snapshots of flow")
        file = "filled.vtu" if when == "filled" else flow[place[when]]
        if file not in self._snapshots:
            self._snapshots[file] = self._read(f"snapshots/{file}", Points)
        return self._snapshots[file]
