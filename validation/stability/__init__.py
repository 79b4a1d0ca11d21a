"""Where each variant of the method fails: one file a failure mode.

Each has `FAILURE_MODE`, its number and name, and `measure(full)`, its rows of the map; some also `curves(full)`, what a
figure is drawn from, and `judge(curves)`, the rows that follow from them.
"""

from importlib import import_module

# module and seconds that it takes on one core, roughly
MODES = {
    "crossing": 40, "stretching": 40, "rotation": 100, "null_space": 100, "time_step": 400, "integration": 7,
    "limits": 40, "ratcheting": 400, "walls": 100, "precision": 70, "conservation": 40, "order": 250,
}  # fmt: skip


def measured(name: str, full: bool = True) -> tuple[str, list, dict | None]:
    """A failure mode's name, its measurements, and the curves of its figure if it has one; Taichi has been started."""
    module = import_module(f"validation.stability.{name}")
    curves = module.curves(full) if hasattr(module, "curves") else None
    found = module.measure(full) if curves is None else module.judge(curves)
    return module.FAILURE_MODE, found, curves
