"""The page of the stability map, drawn from made-up numbers."""

import math
from pathlib import Path

import pandas as pd

from validation.stability.figures import matrix, number, order_figure, page, ratcheting_figure
from validation.stability.measurement import measurements


def rows():
    values = {"ugimp": 0.01, "a method with a long name, and more": 3.0, "lost one": math.nan}
    return pd.DataFrame([one.row("1 mode") for one in measurements("an error", "-", "<=", 0.02, values)])


def test_the_table_has_the_promised_columns_and_no_nan():
    table = rows()
    assert list(table) == ["mode", "method", "measure", "value", "unit", "bound", "holds"]
    assert table.holds.tolist() == [True, False, False]
    assert table.value.tolist() == [0.01, 3.0, math.inf]
    assert table.bound.unique().tolist() == ["<= 0.02"]


def test_numbers_are_short():
    values = (0.0, 0.01968, 1.9e-9, 123456.0, math.inf)
    assert [number(value) for value in values] == ["0", "0.0197", "1.9e-09", "1.2e+05", "lost"]


def test_every_figure_is_drawn_for_any_number_of_methods(tmp_path):
    matrix(rows(), "Failure mode 1").savefig(tmp_path / "matrix.png")
    curves = {f"method {k}": {"time": [0.0, 1.0], "normal": [2.0, 2.0 + k], "janssen": 2.0} for k in range(25)}
    ratcheting_figure(curves).savefig(tmp_path / "ratcheting.png")
    errors = {f"method {k}": {"8": 0.1, "16": 0.02 * k + 0.01} for k in range(12)}
    order_figure({"small": errors, "large": errors, "turn": errors}).savefig(tmp_path / "order.png")
    assert len(list(tmp_path.glob("*.png"))) == 3


def test_the_page_counts_what_holds_and_shows_each_figure():
    words = page(rows(), [Path("out/figures/crossing.png")], Path("out"))
    assert "3 numbers" in words
    assert "1 hold, 2 break" in words
    assert "src='figures/crossing.png'" in words
