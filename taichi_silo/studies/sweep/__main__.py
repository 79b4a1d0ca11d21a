"""Runs of a sweep, as a program: it reads them from its input, and says which part is done, and why one failed."""

import json
import sys

from taichi_silo.studies.sweep.batch import attempt
from taichi_silo.utils.child_process import SAID_NO, STOPPED, given
from taichi_silo.utils.process_pool import STOPPED as WAS_STOPPED


def main() -> None:
    """Simulate; the last line of its errors is a sentence for one run, a list of sentences for several."""
    failures = attempt(given())
    if any(failures):
        print(failures[0] if len(failures) == 1 else json.dumps(failures), file=sys.stderr)
        sys.exit(STOPPED if WAS_STOPPED in failures else SAID_NO)


if __name__ == "__main__":
    main()
