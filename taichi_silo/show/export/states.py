"""What is exported of each state: all that a snapshot holds, and the fields that follow from it."""

from collections.abc import Iterator

import numpy as np

from taichi_silo.runs import snapshot
from taichi_silo.runs.history import History
from taichi_silo.runs.point_fields import FIELDS


def states(history: History) -> Iterator[tuple[dict, np.ndarray, dict[str, np.ndarray]]]:
    """Row of the index, places (n, 2) [m], and arrays by names with units, of each state in the order of time."""
    for number, row in enumerate(history.index.to_dict("records")):
        points = history.state(number)
        arrays = snapshot.stored(points)
        for field in FIELDS.values():
            if field.column not in arrays:
                arrays[field.column] = field.values(points, history.start, history.scene).astype(np.float32)
        yield row, points["position"], arrays
