"""What is compared of a run: its numbers by quantity and state, in SI units."""

from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.measure.wall_pressure import CELL_M, CORNER_M
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.report.states import discharge_rate_kg_per_s_m, forces_of, largest_wall_stress, wall_profile

STATES = {"filling": "filled", "maximum": "N largest", "residual": "residual"}  # of walls.csv: their names here
ROUND_OFF = 1e-9  # of the mean: less is none
NAMES = {"P": "bottom force P", "T": "wall friction T", "N": "wall normal N", "angle": "wall friction angle"}


@dataclass(frozen=True)
class Quantity:
    """One number: name, state ("filled", "peak", "residual" and the like, or empty), unit, value (None if unknown)."""

    name: str
    state: str
    unit: str
    value: float | None

    @property
    def key(self) -> tuple[str, str]:
        """What tells it from the others of a run."""
        return self.name, self.state


def quantities(run: RunFiles) -> list[Quantity]:
    """All of a run; the peak of P is its least value in flow, those of T, N and the angle their largest."""
    found = [Quantity("weight", "", "N/m", _number(run.summary.get("weight_N_per_m")))]
    for name, force in forces_of(run).items():
        unit = "deg" if name == "angle" else "N/m"
        values = {"filled": force.filled, "peak": force.peak, "residual": force.residual}
        found += [Quantity(NAMES[name], state, unit, _number(value)) for state, value in values.items()]
        found.append(Quantity(f"{NAMES[name]}, displacement", "peak", "m", _number(force.peak_m)))
    for state, words in STATES.items():
        largest = largest_wall_stress(run, (state,))
        value = None if largest is None else largest.stress_Pa
        found.append(Quantity("largest wall normal stress", words, "Pa", value))
    summary = run.summary
    whole = _number(_inner(summary, "largest_wall_normal_stress_in_flow", "normal_stress_Pa"))
    found.append(Quantity("largest wall normal stress", "whole flow", "Pa", whole))
    found += [
        Quantity("over-pressure", "", "-", _number(_inner(summary, "largest_overpressure", "factor"))),
        Quantity("stagnant share", "", "-", _number(_inner(summary, "flow_pattern", "stagnant_area_share"))),
        Quantity("discharge rate", "", "kg/s/m", discharge_rate_kg_per_s_m(run)),
    ]
    for side in ("left", "right"):
        thickness = _number(((summary.get("shear_zones") or {}).get(side) or {}).get("thickness_m"))
        found.append(Quantity(f"zone at the {side} wall", "residual", "m", thickness))
    return found


def profile_difference(run: RunFiles, first: RunFiles, state: str) -> tuple[float, float] | None:
    """Root mean square difference of the wall normal stress from the first run's, and the mean of that [Pa].

    Means of both walls, as a pressure cell reads them, without the corner, over the heights that both have; None if
    there are none.
    """
    height, stress = wall_profile(first, state)
    other = wall_profile(run, state)
    if len(height) < 2 or len(other[0]) < 2:
        return None
    clear = (height > height[0] + CORNER_M + 0.5 * CELL_M) & (height >= other[0][0]) & (height <= other[0][-1])
    if not clear.any():
        return None
    difference = np.interp(height[clear], *other) - stress[clear]
    rms, mean = float(np.sqrt(np.mean(difference**2))), float(stress[clear].mean())
    return rms if rms > ROUND_OFF * abs(mean) else 0.0, mean


def _inner(tables: dict, *names: str):
    for name in names:
        tables = (tables or {}).get(name)
    return tables


def _number(value) -> float | None:
    known = isinstance(value, int | float) and np.isfinite(value)
    return float(value) if known else None
