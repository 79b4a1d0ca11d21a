"""Plane strain compression of dense or loose sand: a shear band grows from a weak element.

The study itself is `validation.biaxial`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.biaxial", run_name=__name__)
