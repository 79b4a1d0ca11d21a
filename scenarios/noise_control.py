"""What noise does to the wall force: dense sand between smooth walls, with and without noise control.

The study itself is `validation.noise_control`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.noise_control import noise_control as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
