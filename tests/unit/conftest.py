"""What unit tests share."""

import sys

import pytest


@pytest.fixture
def said(capsys, monkeypatch):
    """A function that runs the program in this process: its exit code, what it prints, and its errors."""
    from taichi_silo.cli import app

    def of(*words):
        monkeypatch.setattr(sys, "argv", ["taichi-silo", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            app.main()
        found = capsys.readouterr()
        return ended.value.code or 0, found.out, found.err

    return of
