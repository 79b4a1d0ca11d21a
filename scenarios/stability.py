"""The stability map: where each variant of the material point method fails, measured.

The study itself is `validation.stability`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.stability.__main__ import stability as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
