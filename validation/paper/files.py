"""The run of one of the paper's cases: forces as means over a period, wall stresses clear of corner and top, points."""

from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.wall_pressure import CELL_M, CORNER_M, SURFACE, cell_mean
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs.result import Result
from taichi_silo.runs.snapshot import figured
from validation.paper.cases import CASES, Case


class NotRun(RunFailed):
    """A run that is not there, has not ended, failed, or whose files are damaged."""


class CaseRun:
    """The run of a case; its files are read when they are asked for, and only once.

    Parameters
    ----------
    folder : of the run; its name tells the case (else give the case).
    case : what was run.
    """

    def __init__(self, folder: Path, case: Case | None = None):
        self.folder = Path(folder)
        self.case = case or CASES[self.folder.name]
        self._states: dict[str, dict[str, np.ndarray]] = {}

    def damaged(self, why: str) -> NotRun:
        """The error that says what is wrong with the folder."""
        return NotRun(f"folder {self.case.name} is damaged: {why}")

    @cached_property
    def result(self) -> Result:
        """The run's folder, opened."""
        try:
            return Result(self.folder)
        except BadInput as error:
            raise NotRun(f"{self.case.name} has not been run") from error

    def check(self, failed: bool = False) -> None:
        """Refuse a run that is not there, has not ended, or, unless such runs are wanted as well, failed."""
        summary = self._read("summary")
        if not summary:
            raise NotRun(f"{self.case.name} has not ended")
        if not self.result.finished and not failed:
            raise NotRun(f"{self.case.name} went wrong: {summary.get('failure') or 'no reason is told'}")

    def _read(self, name: str):
        """An attribute of the result, errors of its file told as those of the case."""
        try:
            return getattr(self.result, name)
        except BadInput as error:
            raise self.damaged(str(error)) from error

    @property
    def summary(self) -> dict:
        """`summary.json`."""
        return self._read("summary")

    @cached_property
    def filled(self) -> pd.Series:
        """State after filling: P, T, N [N/m], angle [degrees]."""
        found = self._read("filled")
        if found is None:
            raise self.damaged("forces.csv has no row of filling")
        return found.rename({"wall_friction_angle_deg": "angle"})

    @cached_property
    def flow(self) -> pd.DataFrame:
        """Rows of flow, as means over one period."""
        rows = self._read("flow").rename(columns={"wall_friction_angle_deg": "angle"})
        few = min(self._read("scene").output.records_per_period, max(len(rows), 1))
        means = rows.select_dtypes("number").rolling(few, center=True, min_periods=few).mean()
        means = means.dropna(subset=["P", "N", "T"])
        if means.empty:
            raise self.damaged("forces.csv has no row of flow")
        return means

    @cached_property
    def progress(self) -> np.ndarray:
        """How far the flow has come in each row, 0 to 1: by displacement, or by time where none is prescribed."""
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
        rows = self._read("flow")
        span = rows.time_s.iloc[-1] - rows.time_s.iloc[0] if len(rows) else 0.0
        speed = (rows.displacement_m.iloc[-1] - rows.displacement_m.iloc[0]) / span if span > 0.0 else 0.0
        return float(speed) if speed > 0.0 else np.nan

    def profile(
        self, state: str, wall: str, stress: str = "normal", reading: str = "node"
    ) -> tuple[np.ndarray, np.ndarray]:
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
        try:
            height, value = self.result.profile(state, wall, f"{stress}_stress_Pa")
        except BadInput as error:
            raise self.damaged(str(error)) from error
        if len(height) < 5:
            raise self.damaged(f"walls.csv lacks the {wall} wall, {state}")
        height, clear = height - height[0], CORNER_M
        if reading == "cell":
            value, clear = cell_mean(height, value, CELL_M), clear + 0.5 * CELL_M
        chosen = (height > clear) & (height < SURFACE * self.case.silo_height_m)
        return height[chosen], value[chosen]

    def points(self, when: str) -> dict[str, np.ndarray]:
        """State "filled", "first" (of flow), "before" (the last but one), or "last", as `Result.state` gives it."""
        if when not in self._states:
            index = figured(self._read("snapshots"))
            flow = list(index.file[index.stage == "flow"])
            place = {"first": 0, "before": -2, "last": -1}
            if when != "filled" and len(flow) < (2 if when == "before" else 1):
                raise self.damaged(f"there are {len(flow)} snapshots of flow")
            name = "filled" if when == "filled" else Path(flow[place[when]]).stem
            try:
                self._states[when] = self.result.state(name)
            except BadInput as error:
                raise self.damaged(str(error)) from error
        return self._states[when]
