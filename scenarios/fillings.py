"""How a silo is filled, and what of it is left in the flow: growing weight, layers, rain.

The study itself is `validation.fillings`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.fillings", run_name=__name__)
