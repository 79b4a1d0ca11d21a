"""The size effect: the same silo from the model of 0.2 m to a bin of 8 m, filled with the same sand.

The study itself is `validation.size_effect`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.size_effect import size_effect as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
