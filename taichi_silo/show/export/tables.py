"""A CSV table of the points for each state of a run, units in the names of its columns, and a table of the states."""

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.runs.result import Result
from taichi_silo.show.export import states

COMPONENTS = {"velocity": ("x", "y"), "stress_Pa": ("xx", "yy", "zz", "xy")}
NAMES = {"velocity": "velocity_{}_m_per_s", "stress_Pa": "stress_{}_Pa"}
DIGITS = {np.dtype(np.float32): 7, np.dtype(np.float64): 10}


def write(run: Result, target: Path, seen: Callable[[], None] = lambda: None) -> int:
    """Write all states of a run into a folder of tables, which is there when all are complete, or not at all.

    Tables of an earlier export are replaced. `seen` hears of each state that is written; returns their number.
    """
    passing = target.absolute().with_name(f"{target.name}.part")
    shutil.rmtree(passing, ignore_errors=True)
    passing.mkdir()
    try:
        rows = []
        for row, position, arrays in states(run):
            name = f"{Path(row['file']).stem}.csv"
            _table(position, arrays).to_csv(passing / name, index=False, encoding="utf-8")
            rows.append({**row, "file": name})
            seen()
        pd.DataFrame(rows).to_csv(passing / "index.csv", index=False, encoding="utf-8")
        target.mkdir(exist_ok=True)
        for old in target.glob("*.csv"):
            old.unlink()
        for file in passing.iterdir():
            file.replace(target / file.name)
    finally:
        shutil.rmtree(passing, ignore_errors=True)
    return len(rows)


def _table(position: np.ndarray, arrays: dict[str, np.ndarray]) -> pd.DataFrame:
    columns = {"identity": arrays["identity"], "x_m": position[:, 0], "y_m": position[:, 1]}
    for name, values in arrays.items():
        if name in COMPONENTS:
            parts = zip(COMPONENTS[name], values.T, strict=False)  # the third of a velocity is 0
            columns |= {NAMES[name].format(component): part for component, part in parts}
        else:
            columns[name] = values
    return pd.DataFrame({name: _short(values) for name, values in columns.items()})


def _short(values: np.ndarray):
    """Numbers as text with the digits that they have; nothing where there is no value."""
    digits = DIGITS.get(values.dtype)
    return values if digits is None else [f"{x:.{digits}g}" if math.isfinite(x) else "" for x in values.tolist()]
