"""The tables of a comparison: each run against the first one, against Janssen, and against measurements."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.wall_pressure import clear_of_corner
from taichi_silo.runs.result import Result
from taichi_silo.show.figures.forces import curve
from taichi_silo.show.report.states import (
    FORCES,
    discharge_rate_kg_per_s_m,
    forces_of,
    largest_wall_stress,
    reading_of,
    wall_profile,
)
from taichi_silo.show.report.words import mm, plain
from taichi_silo.show.theory import filled_beside_janssen
from taichi_silo.studies.compare.measured import Measured, are
from taichi_silo.utils.messages import counted

COLUMNS = ("quantity", "state", "unit", "run", "value", "first_value", "difference", "difference_percent")
PROFILE = "wall normal stress, rms difference"
DEVIATIONS = (
    "run", "file", "quantity", "state", "wall", "unit", "points", "place", "begin", "end", "rms", "largest",
    "largest_at", "measured_peak", "rms_percent", "largest_percent",
)  # fmt: skip
UNITS = {"angle": "deg", "normal_stress_Pa": "Pa", "shear_stress_Pa": "Pa"}
JANSSEN = ("run", "force", "unit", "pressure_ratio", "origin", "theory", "value", "difference", "difference_percent")
LEAST_PA = 1.0  # mean wall stress: a share of less says nothing
ROUND_OFF = 1e-9  # of the mean: a smaller difference is none
ORIGINS = {"K0": "K0 of the law", "measured": "K in the sand"}
STATES = {"filling": "filled", "maximum": "N largest", "residual": "residual"}  # of walls.csv: their names here
NAMES = {"P": "bottom force P", "T": "wall friction T", "N": "wall normal N", "angle": "wall friction angle"}


def differences(runs: list[Result]) -> pd.DataFrame:
    """A row for each quantity, state and run; `difference_percent` is over the first run's value.

    The rows `PROFILE` hold the root mean square difference of the wall normal stress along the wall, whose percentage
    is over the mean of the first run's.
    """
    rows, first = [], list(quantities(runs[0]))
    of_runs = [[value for *_, value in quantities(run)] for run in runs]
    for number, (quantity, state, unit, base) in enumerate(first):
        for run, values in zip(runs, of_runs, strict=True):
            value = values[number]
            rows.append((quantity, state, unit, run.label, value, base, *_against(value, base)))
    for state, words in STATES.items():
        for run in runs:
            found = profile_difference(run, runs[0], state)
            rms, mean = found or (None, None)
            share = 100.0 * found[0] / found[1] if found and found[1] > LEAST_PA else None
            rows.append((PROFILE, words, "Pa", run.label, rms, mean, rms, share))
    return pd.DataFrame(rows, columns=list(COLUMNS), dtype=object)


def quantities(run: Result) -> Iterator[tuple[str, str, str, float | None]]:
    """Name, state ("filled", "peak", "residual" and the like, or empty), unit, and value (None if unknown).

    All runs have the same ones in the same order. The peak of P is its least value in flow, those of T, N and the
    angle their largest.
    """
    summary = run.summary
    yield "weight", "", "N/m", _number(summary, "weight_N_per_m")
    for name, force in forces_of(run).items():
        for state in ("filled", "peak", "residual"):
            yield NAMES[name], state, "deg" if name == "angle" else "N/m", _number(vars(force), state)
        yield f"{NAMES[name]}, displacement", "peak", "m", _number(vars(force), "peak_m")
    for state, words in STATES.items():
        largest = largest_wall_stress(run, (state,))
        yield "largest wall normal stress", words, "Pa", None if largest is None else largest.stress_Pa
    found = _number(summary, "largest_wall_normal_stress_in_flow", "normal_stress_Pa")
    yield "largest wall normal stress", "whole flow", "Pa", found
    yield "over-pressure", "", "-", _number(summary, "largest_overpressure", "factor")
    yield "stagnant share", "", "-", _number(summary, "flow_pattern", "stagnant_area_share")
    yield "discharge rate", "", "kg/s/m", discharge_rate_kg_per_s_m(run)
    for side in ("left", "right"):
        yield f"zone at the {side} wall", "residual", "m", _number(summary, "shear_zones", side, "thickness_m")


def profile_difference(run: Result, first: Result, state: str) -> tuple[float, float] | None:
    """Root mean square difference of the wall normal stress from the first run's, and the mean of that [Pa].

    Means of both walls, as a pressure cell reads them, without the corner, over the heights that both have; None if
    there are none.
    """
    (height, stress), other = wall_profile(first, state), wall_profile(run, state)
    if len(height) < 2 or len(other[0]) < 2:
        return None
    clear = clear_of_corner(height, reading_of(first)) & (height >= other[0][0]) & (height <= other[0][-1])
    if not clear.any():
        return None
    difference = np.interp(height[clear], *other) - stress[clear]
    rms, mean = float(np.sqrt(np.mean(difference**2))), float(stress[clear].mean())
    return rms if rms > ROUND_OFF * abs(mean) else 0.0, mean


def janssen(runs: list[Result]) -> pd.DataFrame:
    """P, T and N after filling of each run beside Janssen's theory, a row for each pressure ratio."""
    rows = []
    for run in runs:
        theory, forces = run.summary.get("janssen") or {}, forces_of(run)
        for key, origin in ORIGINS.items():
            for name in ("P", "T", "N"):
                expected = theory.get(f"{FORCES[name][0]}_{key}")
                if expected is None:
                    continue
                value, ratio = (
                    filled_beside_janssen(theory, name, forces[name].filled),
                    theory.get(f"pressure_ratio_{key}"),
                )
                rows.append((run.label, name, "N/m", ratio, origin, expected, value, *_against(value, expected)))
    return pd.DataFrame(rows, columns=list(JANSSEN), dtype=object)


def deviations(runs: list[Result], measured: list[Measured]) -> pd.DataFrame:
    """A row for each run and each measured quantity.

    Deviations are run less measurement at the measured places; `largest` has its sign, and percentages are over the
    largest measured value. A profile that names no state is set beside all three. Where run and measurement have no
    range in common `points` is 0.
    """
    rows = [row for one in measured for run in runs for row in _of_file(run, one)]
    return pd.DataFrame(rows, columns=list(DEVIATIONS), dtype=object)


def _of_file(run: Result, measured: Measured):
    if measured.kind == "curves":
        for name in measured.quantities:
            known = measured.table[[measured.place, name]].dropna()
            yield _row(run, measured, name, ("", ""), known.to_numpy(float).T, curve(run, name, measured.place))
        return
    for (state, wall), rows in measured.table.groupby(["state", "wall"], sort=False):
        for name in measured.quantities:
            known = rows[["height_m", name]].dropna().to_numpy(float).T
            for one in (state,) if state else STATES:
                yield _row(run, measured, name, (one, wall), known, _profile(run, one, name, wall))


def _profile(run: Result, state: str, name: str, wall: str) -> tuple[np.ndarray, np.ndarray]:
    """Heights and stresses of vertical walls beside sand; empty if there are none."""
    return wall_profile(run, state, name, wall) if run.scene.silo.straight_m else (np.zeros(0), np.zeros(0))


def unused(run: Result, measured: Measured) -> list[str]:
    """Sentences on measured rows that are not set beside a run: which, and why."""
    profile, found = measured.kind == "profile", []
    for wall, rows in measured.table.groupby("wall") if profile else [("", measured.table)]:
        place = rows[measured.place][rows[measured.quantities].notna().any(axis=1)].to_numpy(float)
        x = _places(run, measured, str(wall))
        common = _common(place, x)
        if common.all():
            continue
        of_wall = f" of the {wall} wall" if wall in ("left", "right") else ""
        many = f"{common.sum()} of {counted(len(place), 'row')}{of_wall} {are(common.sum())} compared"
        if not len(x):
            why = "none of its walls is vertical" if profile and not run.scene.silo.straight_m else "it has none yet"
        else:
            where = "above the bottom, where its walls are vertical" if profile else "of its flow"
            rest = f"the rest, at {_span(measured.place, place[~common])}, is outside"
            why = f"{rest} {_span(measured.place, x)} {where}"
        if profile and any(run.scene.silo.feet_m):
            why += "; stresses of inclined walls are in walls.csv, and are not compared"
        found.append(f"{measured.name} beside {run.label}: {many}, as {why}.")
    return found


def _places(run: Result, measured: Measured, wall: str) -> np.ndarray:
    """Where a run has what was measured."""
    name = measured.quantities[0]
    if measured.kind == "curves":
        return curve(run, name, measured.place)[0]
    return max((_profile(run, state, name, wall)[0] for state in STATES), key=len)


def _common(place: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Which places (n,) lie in the range of the places x of a run."""
    return (place >= x[0]) & (place <= x[-1]) if len(x) else np.zeros(len(place), bool)


def _span(name: str, place: np.ndarray) -> str:
    """From the lowest to the highest of places, in words."""
    words = [f"{plain(end)} s" if name == "time_s" else mm(end) for end in (float(place.min()), float(place.max()))]
    return " to ".join(dict.fromkeys(words))


def _row(run: Result, measured: Measured, name: str, where: tuple[str, str], known, found) -> tuple:
    """One comparison: `known` and `found` are (places, values)."""
    head = (run.label, measured.name, name, *where, UNITS.get(name, "N/m"))
    place, value = known
    peak = float(np.abs(value).max()) if len(value) else None
    x, y = found
    common = _common(place, x)
    if not common.any():
        return (*head, 0, measured.place, None, None, None, None, None, peak, None, None)
    place, deviation = place[common], np.interp(place[common], x, y) - value[common]
    rms, k = float(np.sqrt(np.mean(deviation**2))), int(np.argmax(np.abs(deviation)))
    share = (None, None) if not peak else (100.0 * rms / peak, 100.0 * float(deviation[k]) / peak)
    span = (len(place), measured.place, float(place[0]), float(place[-1]))
    return (*head, *span, rms, float(deviation[k]), float(place[k]), peak, *share)


def _against(value: float | None, other: float | None) -> tuple[float | None, float | None]:
    """Difference, and per cent of the other."""
    if value is None or other is None:
        return None, None
    return value - other, 100.0 * (value - other) / abs(other) if other else None


def _number(tables: dict, *names: str) -> float | None:
    """A finite number in tables within tables; None if it is not there."""
    value: Any = tables
    for name in names:
        value = (value or {}).get(name)
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else None
