"""The paper's four mass flows side by side: dense and loose sand, smooth and very rough walls.

The study itself is `validation.four_cases`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.four_cases import four_cases as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
