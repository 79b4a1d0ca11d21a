"""The element tests of the paper: figures 1 and 2, every void ratio and pressure, and the others that it mentions.

The study itself is `validation.element_tests`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.element_tests", run_name=__name__)
