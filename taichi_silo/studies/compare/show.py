"""Comparisons as tables on a screen."""

import pandas as pd
from rich import box
from rich.table import Table

from taichi_silo.show.report.words import NONE, kN, number, plain
from taichi_silo.studies.compare.tables import NAMES

SCALES = {"N/m": (1e-3, "kN/m"), "Pa": (1e-3, "kPa"), "m": (1e3, "mm"), "deg": (1.0, "°"), "-": (1.0, "")}
PLACES = {"displacement_m": (1e3, "mm"), "height_m": (1e3, "mm"), "time_s": (1.0, "s")}
MEASURED = {
    "P": "P", "T": "T", "N": "N", "angle": "wall angle", "left_normal": "N, left wall", "right_normal": "N, right wall",
    "left_shear": "T, left wall", "right_shear": "T, right wall", "normal_stress_Pa": "normal stress",
    "shear_stress_Pa": "shear stress",
}  # fmt: skip


def _table(title: str, *columns: str) -> Table:
    """A table whose first column names the rows."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for number_, column in enumerate(columns):
        table.add_column(column, justify="left" if number_ == 0 else "right", overflow="fold")
    return table


def differences(rows: pd.DataFrame) -> Table:
    """Quantities below each other, runs side by side, per cent against the first."""
    labels = list(dict.fromkeys(rows["run"]))
    table = _table(f"Differences, per cent against {labels[0]}", "quantity", "unit", *labels)
    for (quantity, state), one in rows.groupby(["quantity", "state"], sort=False):
        if one["value"].isna().all():
            continue
        scale, unit = SCALES.get(one["unit"].iloc[0], (1.0, one["unit"].iloc[0]))
        state = "least in flow" if state == "peak" and quantity.startswith(NAMES["P"]) else state
        bare = quantity.endswith("displacement")  # a share of where a peak stands says nothing
        shares = [None if bare or row.run == labels[0] else row.difference_percent for row in one.itertuples()]
        cells = [_cell(value, scale, share) for value, share in zip(one["value"], shares, strict=True)]
        table.add_row(f"{quantity}, {state}" if state else quantity, unit, *cells)
    return table


def _cell(value, scale: float, percent: float | None = None) -> str:
    if value is None:
        return NONE
    return number(scale * value) + ("" if percent is None else f" ({_signed(percent)})")


def _signed(percent: float | None) -> str:
    """Per cent to a tenth; of more than a hundred to one; of more than a thousand only that it is so."""
    if percent is not None and abs(percent) >= 1000.0:
        return f"{'>' if percent > 0.0 else '< −'}999\u00a0%"
    return NONE if percent is None else f"{percent:+.{1 if abs(percent) < 100.0 else 0}f}\u00a0%".replace("-", "−")


def janssen(rows: pd.DataFrame) -> Table:
    """Forces after filling beside theory."""
    table = _table(
        "Janssen's theory, after filling (kN/m)", "run", "force", "run's", "theory", "K", "origin", "run against it"
    )
    for row in rows.itertuples():
        cells = (kN(row.value), kN(row.theory), number(row.pressure_ratio), row.origin)
        table.add_row(row.run, row.force, *cells, _signed(row.difference_percent))
    return table


def deviations(rows: pd.DataFrame) -> Table:
    """Runs beside the measurements of one file."""
    title = f"Deviation from {rows['file'].iloc[0]}: run − measured, per cent of the measured peak"
    head = ("run", "quantity", "unit", "peak", "over", "points", "rms", "per cent", "largest", "per cent", "at")
    table = _table(title, *head)
    for row in rows.itertuples():
        scale, unit = SCALES[row.unit]
        step, measure = PLACES[row.place]
        what = ", ".join(word for word in (MEASURED[row.quantity], row.state, row.wall) if word and word != "both")
        start = (row.run, what, unit, _cell(row.measured_peak, scale))
        if not row.points:
            table.add_row(*start, "nothing in common", "0")
            continue
        table.add_row(
            *start, f"{plain(step * row.begin)} to {plain(step * row.end)} {measure}", str(row.points),
            number(scale * row.rms), NONE if row.rms_percent is None else f"{row.rms_percent:.1f}\u00a0%",
            number(scale * row.largest), _signed(row.largest_percent), f"{plain(step * row.largest_at)} {measure}",
        )  # fmt: skip
    return table
