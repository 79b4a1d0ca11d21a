"""`report.html` of a study of convergence: its numbers with their error bars, and how far to trust them."""

from pathlib import Path

import pandas as pd

from taichi_silo.scene.scene import Scene
from taichi_silo.show import html
from taichi_silo.show.figures.convergence import ROUND_OFF, shown_in
from taichi_silo.show.report.tables import ReportTable
from taichi_silo.show.report.words import NONE, number, per_cent
from taichi_silo.utils import atomic_write

PARTS = {"grid": "cells", "length": "length of the law", "speed": "speed of the bottom", "time": "rest"}
CARDS = ("P_residual", "T_residual", "N_residual", "zone_thickness")
WORDS = {
    "convergence": "Numbers against the size of the cells, with the bands that hold their limits",
    "cost": "Distance of the forces from their limits against the cost of the runs",
}


def write_page(file: Path, scene: Scene, ended: str, numbers: pd.DataFrame, runs: pd.DataFrame, figures: list[Path]):
    """Write the page of a study, in one piece or not at all.

    `numbers` and `runs` are its tables `converge.csv` and `runs.csv`.
    """
    text = html.render(
        Path(__file__).with_name("convergence.html.j2"), title=_title(scene), ended=ended, cards=_cards(numbers),
        numbers=_numbers(numbers), parts=_parts(numbers), runs=_runs(runs), figures=[
            {"data": html.data_uri(one.read_bytes(), "image/png"), "words": WORDS[one.stem]} for one in figures
        ],
    )  # fmt: skip
    with atomic_write.written(file) as passing:
        passing.write_text(text, encoding="utf-8", errors="replace")  # a name may be of any bytes


def _title(scene: Scene) -> str:
    silo = scene.silo
    return f"{silo.width_m:g} m × {silo.height_m:g} m, {scene.sand.name}, e₀ = {scene.sand.void_ratio:g}"


def with_error(value: float, error: float, unit: str) -> tuple[str, str]:
    """A number with its error, both to the second digit of the error, and the unit that they are in.

    An error of round-off has no digit that counts: such a number has five of its own.
    """
    name, factor = shown_in(unit)
    value, error = factor * value, factor * error
    if error != error:
        return f"{number(value)} ± {NONE}", name
    size = abs(error) if abs(error) > ROUND_OFF * abs(value) else 1e-3 * abs(value)
    places = 1
    while size * 10**places < 9.5 and places < 8:
        places += 1
    return f"{value:,.{places}f} ± {error:,.{places}f}", name


def _cards(numbers: pd.DataFrame) -> list[dict]:
    rows, cards = numbers.set_index("quantity"), []
    for name in (one for one in CARDS if one in rows.index):
        row = rows.loc[name]
        value, unit = with_error(row["value"], row["error"], row["unit"])
        cards.append({"name": row["in_words"], "value": value, "unit": unit,
                      "words": f"{per_cent(row['relative_error'])} {row['over']}"})  # fmt: skip
    return cards


def _numbers(numbers: pd.DataFrame) -> ReportTable:
    rows = []
    for _, row in numbers.iterrows():
        value, unit = with_error(row["value"], row["error"], row["unit"])
        finest = number(shown_in(row["unit"])[1] * row["finest_run"], 4)
        rows.append((row["in_words"], value, unit, per_cent(row["relative_error"]), finest))
    return ReportTable(("quantity", "value and error", "unit", "error over its measure", "finest run"), tuple(rows),
                       "Forces over the weight of the sand, wall stresses over the largest of their profile, all else "
                       "over itself.")  # fmt: skip


def _parts(numbers: pd.DataFrame) -> ReportTable:
    rows = []
    for _, row in numbers.iterrows():
        cells = []
        for part in PARTS:
            share = row[f"{part}_error"] / row["error"] if row["error"] else 0.0
            order = row[f"{part}_order"]
            told = "" if order is None or order != order else f", order {order:.2g}"
            cells.append(f"{100.0 * share:.0f} %, {row[f'{part}_trust']}{told}" if share == share else NONE)
        rows.append((row["in_words"], *cells))
    note = "Share of each part in the error, which is the root of the sum of their squares."
    return ReportTable(("quantity", *PARTS.values()), tuple(rows), note)


def _runs(runs: pd.DataFrame) -> ReportTable:
    rows = [
        (str(row["step"]), number(1e3 * row["cell_size_m"]), number(1e3 * row["length_m"]),
         number(1e3 * row["speed_m_per_s"]), f"{row['points']:,}", number(row["core_seconds"]))
        for _, row in runs.iterrows()
    ]  # fmt: skip
    return ReportTable(("step", "cells (mm)", "length (mm)", "speed (mm/s)", "points", "core-seconds"), tuple(rows))
