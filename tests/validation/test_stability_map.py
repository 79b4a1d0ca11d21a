"""The table, figures and page of the stability map, from made-up numbers."""

import math
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pandas as pd
import pytest

from validation.in_parallel import in_parallel
from validation.stability import MODES
from validation.stability.figures import matrix, number, order_figure, page, ratcheting_figure
from validation.stability.measurement import Measurement, measurements


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


def test_a_number_that_is_none_never_holds():
    assert not Measurement("x", "y", math.nan, "-", "<=", 1.0).holds
    assert not Measurement("x", "y", math.inf, "-", "<=", 1.0).holds
    assert Measurement("x", "y", 1.0, "-", ">=", 1.0).holds


def test_every_mode_of_the_map_can_be_found_by_its_name():
    for mode, name in enumerate(MODES, start=1):
        assert import_module(f"validation.stability.{name}").FAILURE_MODE.split()[0] == str(mode)


def test_parts_run_in_processes_and_one_that_fails_stops_no_other(capsys):
    assert in_parallel(str.upper, {"good": ("done",), "bad": (1,)}, {"good": 1.0, "bad": 2.0}).keys() == {"bad"}
    assert "DONE" in capsys.readouterr().out


@pytest.mark.long
def test_the_command_measures_a_mode_and_draws_the_map(tmp_path):
    command = [sys.executable, "-m", "validation.stability", "--quick", "--mode", "integration", "--output", tmp_path]
    subprocess.run(command, check=True, cwd=Path(__file__).parents[2])
    assert len(pd.read_csv(tmp_path / "table.csv")) == 2
    assert (tmp_path / "page.html").exists() and (tmp_path / "figures" / "integration.png").exists()
