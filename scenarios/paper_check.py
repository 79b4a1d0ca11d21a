"""The paper's statements on silo flow (sections 6, 7 and 8) against our runs: what agrees, what does not, and why.

The study itself is `validation.paper.recheck`.
"""

import sys
from pathlib import Path

from taichi_silo.cli import command_line

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from validation.paper.recheck import paper_check as scenario  # noqa: E402

if __name__ == "__main__":
    command_line.command(scenario)
