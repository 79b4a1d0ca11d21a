"""The paper's statements on silo flow (sections 6, 7 and 8) against our runs: what agrees, what does not, and why.

The study itself is `validation.paper.recheck`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.paper.recheck", run_name=__name__)
