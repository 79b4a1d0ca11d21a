"""With standard output closed every command does its work, and ends as it would if somebody listened."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from tests.unit.test_program import TINY

COMMANDS = (  # words, exit code, what it leaves
    ("run tiny.toml --output out --no-film --no-figures", 0, "out/forces.csv"),
    ("run tiny.toml --output out --no-film --no-figures", 2, ""),
    ("run tiny.toml --check", 0, ""),
    ("run tiny.toml --explain", 0, ""),
    ("resume out", 0, "out/summary.json"),
    ("report out", 0, "out/report.html"),
    ("export out --format csv --output tables", 0, "tables"),
    ("compare out --janssen --output compared", 0, "compared/compare.csv"),
    ("gallery out --output page", 0, "page/index.html"),
    ("scene --output whole.toml", 0, "whole.toml"),
    ("scene", 0, ""),
    ("list --json", 0, ""),
    ("eurocode tiny.toml", 0, ""),
    ("doctor --output place", 0, ""),
    ("--help", 0, ""),
    ("no-command", 2, ""),
)
PROGRAM = """
    import sys

    from taichi_silo.cli.app import make
    from taichi_silo.cli.command_line import serve

    assert sys.stdout is None
    for words in sys.argv[1:]:
        try:
            serve(make(), "taichi-silo", words.split())
        except SystemExit as end:
            print(end.code, file=sys.stderr)
"""


@pytest.mark.skipif(os.name != "posix", reason="the shell of POSIX")
def test_every_command_works_without_a_standard_output(tmp_path):
    (tmp_path / "tiny.toml").write_text(TINY)
    program = [sys.executable, "-c", textwrap.dedent(PROGRAM), *(words for words, *_ in COMMANDS)]
    done = subprocess.run(
        ["bash", "-c", 'exec "$@" >&-', "bash", *program], cwd=tmp_path, stderr=subprocess.PIPE, text=True, timeout=400,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
    )  # fmt: skip
    lines = done.stderr.splitlines()
    codes = [int(line) for line in lines if line.isdigit()]
    assert codes == [code for _, code, _ in COMMANDS], done.stderr
    assert [line for line in lines if not line.isdigit() and not line.startswith("Error: ")] == []
    assert [name for _, _, name in COMMANDS if name and not (tmp_path / name).exists()] == []
