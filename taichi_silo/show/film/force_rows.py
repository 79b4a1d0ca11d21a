"""The forces that a film shows: as they were recorded, or where the flow is fast their running median with a band."""

import numpy as np
import pandas as pd

from taichi_silo.runs.inclined_walls import none_vertical, of_which
from taichi_silo.runs.result import Result

PERIODS, SHARE = 2, 0.05  # of the column, and of the rows of the flow, over which the median goes at least
ENDS = (0.05, 0.95)  # quantiles at which the band ends
NOISY = 0.03  # width of the band, as a share of the weight, from which on the median is shown
NOTE = "lines: running median; bands: 5 to 95 %"


class ForceRows:
    """Rows of a run's forces in the order of time.

    Attributes
    ----------
    times : (n,) [s].
    forces : (n, 3) P, T and N [N/m].
    spread : (n, 3, 2) lower and upper end of the band [N/m]; None where the rows are drawn as they are.
    note : what is drawn, if it is not the rows.

    """

    def __init__(self, history: Result):
        table = history.forces
        self.rows = table.to_dict("records")
        silo = history.scene.silo
        self.times = table["time_s"].to_numpy(float)
        self.forces = table[["P", "T", "N"]].to_numpy(float)
        self.spread: np.ndarray | None = None
        self.note = of_which(silo) if none_vertical(silo) else ""
        flow = np.flatnonzero(table["stage"] == "flow")
        if not len(flow):
            return
        window = max(PERIODS * history.scene.output.records_per_period, round(SHARE * len(flow)))
        median, spread = running(self.forces[flow], window)
        weight = history.scene.weight_N_per_m
        if np.nanmedian((spread[..., 1] - spread[..., 0]).max(axis=1)) <= NOISY * weight:
            return
        self.spread = np.repeat(self.forces[..., None], 2, axis=2)
        self.note = f"{self.note}; {NOTE}".removeprefix("; ")
        self.forces[flow], self.spread[flow] = median, spread

    @property
    def largest(self) -> float:
        """Of the forces that are drawn [N/m]; 0 without any."""
        return float(np.max(self.forces[np.isfinite(self.forces)], initial=0.0))


def running(forces: np.ndarray, window: int) -> tuple[np.ndarray, np.ndarray]:
    """The running median (n, k) of columns, and the ends (n, k, 2) of their bands, over so many rows around each.

    The window narrows at both ends, so that a steep start stays steep.
    """
    half = min(window // 2, max(0, (len(forces) - 1) // 2))
    rolled = pd.DataFrame(forces).rolling(2 * half + 1, center=True, min_periods=1)
    parts = [part.to_numpy(copy=True) for part in (rolled.median(), *(rolled.quantile(end) for end in ENDS))]
    for row in range(half):
        for at, those in (
            (row, slice(0, 2 * row + 1)),
            (len(forces) - 1 - row, slice(len(forces) - 1 - 2 * row, None)),
        ):
            rows = pd.DataFrame(forces[those])  # which leaves out what is no number
            parts[0][at] = rows.median()
            parts[1][at], parts[2][at] = rows.quantile(list(ENDS)).to_numpy()
    return parts[0], np.stack(parts[1:], axis=2)
