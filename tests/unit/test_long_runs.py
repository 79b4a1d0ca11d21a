"""A run of hours is asked for at a terminal, and announced elsewhere; its cost stands in --check, too."""

import io
import sys

import pytest
import typer

from taichi_silo.cli.long_runs import permission
from taichi_silo.errors import Stopped
from taichi_silo.runs.cost_estimate import Cost, clock
from taichi_silo.runs.observers import progress
from taichi_silo.utils.console import Console

HOURS = 2.5 * 3600.0


@pytest.fixture
def asked(monkeypatch):
    """What is asked at a terminal, where the answer is no."""
    questions = []
    monkeypatch.setattr(sys, "stdin", type("Terminal", (io.StringIO,), {"isatty": lambda self: True})())
    monkeypatch.setattr(typer, "confirm", lambda words, **_: questions.append(words))
    return questions


def test_more_than_an_hour_is_asked_for_and_no_means_that_nothing_is_written(asked):
    with pytest.raises(Stopped, match="not begun, as you answered, and nothing is written"):
        permission(Console(), yes=False)(HOURS)
    assert asked == ["The run takes about 2:30 h. Begin?"]


def test_less_than_an_hour_or_what_nobody_knows_is_not_asked_for(asked, capsys):
    for seconds in (3599.0, float("nan")):
        permission(Console(), yes=False)(seconds)
    assert not asked and not capsys.readouterr().out


def test_with_yes_there_is_a_word_and_no_question(asked, capsys):
    permission(Console(), yes=True)(HOURS)
    assert not asked
    assert capsys.readouterr().out.startswith("The run takes about 2:30 h; larger cells")


def test_where_no_terminal_can_answer_nobody_is_asked(asked, capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    permission(Console(), yes=False)(HOURS)
    assert not asked and "2:30 h" in capsys.readouterr().out


def test_where_nothing_is_said_the_cost_is_not_found_out(monkeypatch):
    monkeypatch.setattr(progress, "predict", lambda simulation: pytest.fail("steps were tried for it"))
    console = Console(quiet=True)
    progress.ProgressLine(console.terminal, permission(console, yes=False)).prepare(None)


def test_a_cost_is_told_in_minutes_or_hours():
    assert [clock(seconds) for seconds in (0.4, 65.0, 3599.9, 3600.0, 9000.0)] == [
        "0:00",
        "1:05",
        "60:00",
        "1:00 h",
        "2:30 h",
    ]
    assert (
        Cost(5000, 60_000, 130.0, threads=2).words()
        == "5,000 points, about 60,000 steps: some 1:05 minutes of stepping"
    )
    assert Cost(5000, 60_000, 9000.0).words().endswith("some 2:30 h of stepping")
