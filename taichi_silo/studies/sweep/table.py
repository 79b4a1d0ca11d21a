"""A sweep as a table, one row a run, with what was varied and what was found; and what of it is drawn."""

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.studies.sweep.runs import Run
from taichi_silo.studies.sweep.variations import used
from taichi_silo.utils import atomic_write
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options

FORCES = {"P": ("bottom_N_per_m", "least", "min"), "T": ("shear_N_per_m", "largest", "max"),
          "N": ("normal_N_per_m", "largest", "max")}  # fmt: skip
ANGLE = "wall_friction_angle_deg"
PRESSURE = "largest_wall_normal_stress_pressure_cell_Pa"
NO_NUMBERS = ("flow_pattern",)


def row(name: str, run: Run, paths: list[str], failure: str = "") -> dict:
    """Row of one run: its name, its values at dotted paths, what it `found`, what it cost, and whether it failed.

    `failure` is why it left nothing, if that is known.
    """
    summary = run.summary
    cost, finished = summary.get("cost", {}), summary.get("finished", False) and not failure
    return {
        "run": name, **used(run.scene, paths), **found(summary),
        "points": run.scene.points, "steps": cost.get("steps"), "core_seconds": cost.get("seconds"),
        "warnings": len(summary.get("warnings", [])), "finished": finished,
        "failure": "" if finished else failure or summary.get("failure", ""),
    }  # fmt: skip


def found(summary: dict) -> dict:
    """What a run found, None where it found nothing.

    P, T, N after filling, their extreme in flow and their residual [N/m]; wall friction angle [deg] at the same times;
    largest wall normal stress of all states away from the corner, at a node and as a pressure cell reads it [Pa], and
    the largest factor of it to that after filling; flow pattern, and the share of sand that stands still; sand that has
    left [kg/m].
    """
    filling, peak, residual = (summary.get(key, {}) for key in ("filling", "peak", "residual"))
    cells = {}
    for force, (key, words, extreme) in FORCES.items():
        cells[f"{force}_filled_N_per_m"] = filling.get(key)
        cells[f"{force}_{words}_N_per_m"] = peak.get(f"{extreme}_{key}", {}).get("value")
        cells[f"{force}_residual_N_per_m"] = residual.get(key)
    cells[f"filled_{ANGLE}"] = filling.get(ANGLE)
    cells[f"largest_{ANGLE}"] = peak.get(f"max_{ANGLE}", {}).get("value")
    cells[f"residual_{ANGLE}"] = residual.get(ANGLE)
    stresses = summary.get("largest_wall_normal_stress_Pa", {}).values()
    for kind in ("node", "pressure_cell"):
        known = [state[kind] for state in stresses if state.get(kind) is not None]
        cells[f"largest_wall_normal_stress_{kind}_Pa"] = max(known, default=None)
    cells["largest_overpressure"] = summary.get("largest_overpressure", {}).get("factor")
    pattern = summary.get("flow_pattern", {})
    cells |= {"flow_pattern": pattern.get("kind"), "stagnant_area_share": pattern.get("stagnant_area_share")}
    return cells | {"discharged_kg_per_m": summary.get("ledger", {}).get("discharged_kg_per_m")}


def leave(file: Path, rows: Iterable[dict]) -> pd.DataFrame:
    """Write the table, in one piece or not at all, and return it."""
    table = pd.DataFrame(list(rows))
    with atomic_write.written(file) as passing:
        table.to_csv(passing, index=False, float_format="%.6g")
    return table


class Response(Options):
    """Columns of the sweep's table that are drawn."""

    x: str | None = None  # what varied, first in the figure; what varies first if absent
    y: str = PRESSURE  # what was found
    colour: str | None = None  # what tells the points apart, varied or found; another that varied if absent

    def check(self, columns: list[str]) -> None:
        """Refuse what the table of these varied columns does not hold, with the name that was perhaps meant."""
        numbers = [name for name in found({}) if name not in NO_NUMBERS]
        _one_of("response.y", self.y, numbers)
        if self.x is not None:
            _one_of("response.x", self.x, columns)
        if self.colour is not None:
            _one_of("response.colour", self.colour, [*columns, *found({})])


def _one_of(name: str, value: str, known: Iterable[str]) -> None:
    known = list(known)
    if value not in known:
        meant = near(value, known, 0.4)
        right = f"did you mean {meant}?" if meant else f"it must be one of {', '.join(known)}"
        raise BadInput(f"{name} is {shown(value)}; {right}")
