"""The stability map: where each variant of the material point method fails, measured.

The study itself is `validation.stability`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.stability", run_name=__name__)
