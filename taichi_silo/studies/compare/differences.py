"""The table of differences: every quantity of every run against the first one; and each run against Janssen."""

import pandas as pd

from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.report.states import FORCES, forces_of
from taichi_silo.studies.compare.quantities import STATES, profile_difference, quantities

COLUMNS = ("quantity", "state", "unit", "run", "value", "first_value", "difference", "difference_percent")
PROFILE = "wall normal stress, rms difference"
JANSSEN = ("run", "force", "unit", "pressure_ratio", "origin", "theory", "value", "difference", "difference_percent")
LEAST_PA = 1.0  # mean wall stress: a share of less says nothing
ORIGINS = {"K0": "K0 of the law", "measured": "K in the sand"}


def differences(runs: list[RunFiles]) -> pd.DataFrame:
    """A row for each quantity, state and run; `difference_percent` is over the first run's value.

    The rows `PROFILE` hold the root mean square difference of the wall normal stress along the wall, whose percentage
    is over the mean of the first run's.
    """
    of_runs = [{one.key: one for one in quantities(run)} for run in runs]
    rows = []
    for key, base in of_runs[0].items():
        for run, found in zip(runs, of_runs, strict=True):
            rows.append(_row(*key, base.unit, run.label, found[key].value, base.value))
    for state, words in STATES.items():
        for run in runs:
            found = profile_difference(run, runs[0], state)
            rms, mean = found or (None, None)
            share = 100.0 * rms / mean if mean is not None and mean > LEAST_PA else None
            rows.append((PROFILE, words, "Pa", run.label, rms, mean, rms, share))
    return pd.DataFrame(rows, columns=list(COLUMNS), dtype=object)


def _row(quantity: str, state: str, unit: str, label: str, value, first) -> tuple:
    return quantity, state, unit, label, value, first, *_against(value, first)


def _against(value: float | None, other: float | None) -> tuple[float | None, float | None]:
    """Difference, and per cent of the other."""
    if value is None or other is None:
        return None, None
    return value - other, 100.0 * (value - other) / abs(other) if other else None


def janssen(runs: list[RunFiles]) -> pd.DataFrame:
    """P, T and N after filling of each run beside Janssen's theory, a row for each pressure ratio."""
    rows = []
    for run in runs:
        theory, forces = run.summary.get("janssen") or {}, forces_of(run)
        for key, origin in ORIGINS.items():
            for name in ("P", "T", "N"):
                expected = theory.get(f"{FORCES[name][0]}_{key}")
                if expected is None:
                    continue
                value, ratio = forces[name].filled, theory.get(f"pressure_ratio_{key}")
                rows.append((run.label, name, "N/m", ratio, origin, expected, value, *_against(value, expected)))
    return pd.DataFrame(rows, columns=list(JANSSEN), dtype=object)
