"""How far runs are from measurements: root mean square and largest deviation over the range that both have."""

import numpy as np
import pandas as pd

from taichi_silo.runs.result import Result
from taichi_silo.show.figures.forces import curve
from taichi_silo.show.report.states import wall_profile
from taichi_silo.studies.compare.measured import Measured

COLUMNS = (
    "run", "file", "quantity", "state", "wall", "unit", "points", "place", "begin", "end", "rms", "largest",
    "largest_at", "measured_peak", "rms_percent", "largest_percent",
)  # fmt: skip
UNITS = {"angle": "deg", "normal_stress_Pa": "Pa", "shear_stress_Pa": "Pa"}
ALL_STATES = ("filling", "maximum", "residual")


def deviations(runs: list[Result], measured: list[Measured]) -> pd.DataFrame:
    """A row for each run and each measured quantity.

    Deviations are run less measurement at the measured places; `largest` has its sign, and percentages are over the
    largest measured value. A profile that names no state is set beside all three. Where run and measurement have no
    range in common `points` is 0.
    """
    rows = [row for one in measured for run in runs for row in _of_file(run, one)]
    return pd.DataFrame(rows, columns=list(COLUMNS), dtype=object)


def _of_file(run: Result, measured: Measured):
    if measured.kind == "curves":
        for name in measured.quantities:
            known = measured.table[[measured.place, name]].dropna()
            yield _row(run, measured, name, ("", ""), known.to_numpy(float).T, curve(run, name, measured.place))
        return
    for (state, wall), rows in measured.table.groupby(["state", "wall"], sort=False):
        for name in measured.quantities:
            known = rows[["height_m", name]].dropna().to_numpy(float).T
            for one in (state,) if state else ALL_STATES:
                yield _row(run, measured, name, (one, wall), known, wall_profile(run, one, name, wall))


def _row(run: Result, measured: Measured, name: str, where: tuple[str, str], known, found) -> tuple:
    """One comparison: `known` and `found` are (places, values)."""
    head = (run.label, measured.name, name, *where, UNITS.get(name, "N/m"))
    place, value = known
    peak = float(np.abs(value).max()) if len(value) else None
    x, y = found
    common = (place >= x[0]) & (place <= x[-1]) if len(x) else np.zeros(len(place), bool)
    if not common.any():
        return (*head, 0, measured.place, None, None, None, None, None, peak, None, None)
    place, deviation = place[common], np.interp(place[common], x, y) - value[common]
    rms, k = float(np.sqrt(np.mean(deviation**2))), int(np.argmax(np.abs(deviation)))
    share = (None, None) if not peak else (100.0 * rms / peak, 100.0 * float(deviation[k]) / peak)
    span = (len(place), measured.place, float(place[0]), float(place[-1]))
    return (*head, *span, rms, float(deviation[k]), float(place[k]), peak, *share)
