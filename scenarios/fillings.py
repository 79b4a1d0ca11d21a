"""How a silo is filled, and what of it is left in the flow: growing weight, layers, rain.

The study itself is `validation.fillings`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.fillings import fillings as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
