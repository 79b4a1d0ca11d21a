"""Speed against accuracy: what each setting of the method costs, and how wrong it makes the answer.

The study itself is `validation.accuracy`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.accuracy.__main__ import chart as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
