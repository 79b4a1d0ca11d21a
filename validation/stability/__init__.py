"""Where each variant of the method fails: one file a failure mode.

Each has `FAILURE_MODE`, its number and name, and `measure(full)`, its rows of the map; some also `curves(full)`, what a
figure is drawn from, and `judge(curves)`, the rows that follow from them.
"""

import json
from importlib import import_module
from pathlib import Path

import pandas as pd

from taichi_silo.mpm import runtime
from taichi_silo.utils import atomic_write

# module and seconds that it takes on one core, roughly
MODES = {
    "crossing": 40, "stretching": 40, "rotation": 100, "null_space": 100, "time_step": 400, "integration": 7,
    "limits": 40, "ratcheting": 400, "walls": 100, "precision": 70, "conservation": 40, "order": 250,
    "sheared_layer": 300,
}  # fmt: skip


def measured(name: str, full: bool = True) -> tuple[str, list, dict | None]:
    """A failure mode's name, its measurements, and the curves of its figure if it has one; Taichi has been started."""
    module = import_module(f"validation.stability.{name}")
    curves = module.curves(full) if hasattr(module, "curves") else None
    found = module.measure(full) if curves is None else module.judge(curves)
    return module.FAILURE_MODE, found, curves


def leave(name: str, full: bool, parts: Path) -> str:
    """Measure a mode and leave its rows and curves; says how many numbers hold."""
    runtime.init()
    failure_mode, found, curves = measured(name, full)
    if curves is not None:
        (parts / f"{name}.json").write_text(json.dumps(curves))
    with atomic_write.written(parts / f"{name}.csv") as passing:
        pd.DataFrame([one.row(failure_mode) for one in found]).to_csv(passing, index=False, float_format="%.6g")
    return f"{sum(one.holds for one in found)} of {len(found)} hold"
