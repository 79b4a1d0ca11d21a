"""All silo flows of the paper: 4 mass flows, 12 controlled outflows, 1 free outflow; figures and table of statements.

The study itself is `validation.paper`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.paper.__main__ import paper as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
