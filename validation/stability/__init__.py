"""Where each variant of the method fails: one file a failure mode.

Each has `MODE`, its name, and `cells(full)`, its rows of the map; some also `data(full)`, what a figure is drawn from,
and `cells_from(data)`.
"""

from importlib import import_module

# module and seconds that it takes on one core, roughly
MODES = {
    "crossing": 40, "stretching": 40, "rotation": 100, "null_space": 100, "time_step": 400, "integration": 7,
    "limits": 40, "ratcheting": 400, "walls": 100, "precision": 70, "conservation": 40, "order": 250,
}  # fmt: skip


def measure(name: str, full: bool = True) -> tuple[list, dict | None]:
    """Cells of a failure mode, and the data of its figure if it has one; Taichi has been started."""
    module = import_module(f"validation.stability.{name}")
    if hasattr(module, "data"):
        data = module.data(full)
        return module.cells_from(data), data
    return module.cells(full), None
