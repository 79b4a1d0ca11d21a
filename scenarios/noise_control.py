"""What noise does to the wall force: dense sand between smooth walls, with and without noise control.

The study itself is `validation.noise_control`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.noise_control", run_name=__name__)
