"""The element tests of the paper: figures 1 and 2, every void ratio and pressure, and the others that it mentions.

The study itself is `validation.element_tests`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.element_tests import paper_element_tests as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
