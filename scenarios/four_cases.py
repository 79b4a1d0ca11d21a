"""The paper's four mass flows side by side: dense and loose sand, smooth and very rough walls.

The study itself is `validation.four_cases`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.four_cases", run_name=__name__)
