"""Speed against accuracy: what each dial of the method costs, and how wrong it makes the answer.

The study itself is `validation.accuracy`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.accuracy", run_name=__name__)
