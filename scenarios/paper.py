"""All silo flows of the paper: 4 mass flows, 12 controlled outflows, 1 free outflow; figures and table of statements.

The study itself is `validation.paper`.
"""

import runpy
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
runpy.run_module("validation.paper", run_name=__name__)
