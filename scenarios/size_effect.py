"""The size effect: the same silo from the model of 0.2 m to a bin of 8 m, filled with the same sand.

The study itself is `validation.size_effect`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.size_effect", run_name=__name__)
