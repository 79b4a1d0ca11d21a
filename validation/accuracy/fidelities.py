"""The three named settings, chosen from the Pareto front of the error of N against cost."""

from pathlib import Path

import pandas as pd
import tomli_w

from taichi_silo.scene.fidelity import Fidelity
from taichi_silo.utils import atomic_write
from validation.accuracy.errors import ERRORS, pareto_front
from validation.accuracy.plan import REFERENCE, ROUNDING

PATHS = ("grid.cell_size_m", "flow.speed_m_per_s", "grid.points_per_cell")  # what a fidelity may set
DRAFT, STANDARD, CONVERGED = 0.15, 0.05, 0.02  # greatest error of N


def choose(rows: pd.DataFrame, floor: float) -> dict[str, Fidelity]:
    """The cheapest rows of `chart.csv` within 15, 5 and 2 % of N (or the scatter, if that is more), by name.

    Where none is as accurate the most accurate is taken. Only rows count whose other values are those of the base; the
    reference itself does not, having no error to tell. Nothing without base or reference.
    """
    bases = rows[(rows.dial == ROUNDING) & (rows.setting == "none")]
    if bases.empty:
        return {}
    base = bases.iloc[0]
    itself = rows.key.isin(rows.key[rows.dial == REFERENCE])
    some = rows[(rows.purpose == "accuracy") & ~itself].drop_duplicates("key")
    for path in rows.columns[rows.columns.get_loc("purpose") + 1 : rows.columns.get_loc("cost_core_seconds")]:
        if path not in PATHS:
            some = some[(some[path] == base[path]) | (some[path].isna() & pd.isna(base[path]))]
    best = some[pareto_front(some.cost_core_seconds, some.error_N)].sort_values("cost_core_seconds")
    if best.empty:
        return {}
    found = {}
    for name, bound in (("draft", DRAFT), ("standard", STANDARD), ("converged", max(CONVERGED, floor))):
        within = best[best.error_N <= bound]
        row = (within if len(within) else best.tail(1)).iloc[0]
        measured = {column: float(row[column]) for column in (*ERRORS, "cost_core_seconds") if pd.notna(row[column])}
        settings = {path: row[path].item() for path in PATHS if path in row}
        found[name] = Fidelity(settings=settings, reference=row.reference, **measured)
    return found


def write(found: dict[str, Fidelity], file: Path) -> None:
    """Leave a file that `taichi_silo.scene.fidelity` reads; in one piece or not at all."""
    with atomic_write.written(file) as passing:
        passing.write_text(tomli_w.dumps({name: one.model_dump(exclude_none=True) for name, one in found.items()}))
