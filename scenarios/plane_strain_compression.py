"""Plane strain compression of dense or loose sand: a shear band grows from a weak element.

The study itself is `validation.biaxial`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.biaxial.__main__ import plane_strain_compression as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
