"""The states of a run in files of other programs.

Each format is a module with a function `write(run, target, seen)`.
"""

from collections.abc import Iterator

import numpy as np

from taichi_silo.runs import snapshot
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.runs.result import Result


def states(run: Result) -> Iterator[tuple[dict, np.ndarray, dict[str, np.ndarray]]]:
    """Row of `snapshots`, places (n, 2) [m], and arrays by names with units, of each state in the order of time.

    The arrays are those of the snapshot, and the fields that follow from it.
    """
    for number, row in enumerate(run.snapshots.to_dict("records")):
        points = run.state(number)
        arrays = snapshot.stored(points)
        for field in FIELDS.values():
            if field.column not in arrays:
                arrays[field.column] = field.values(points, run.start, run.scene).astype(np.float32)
        yield row, points["position"], arrays
