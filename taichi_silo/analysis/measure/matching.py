"""The same points in two states, of which some may have left between."""

import numpy as np


def matched(before: dict, now: dict) -> dict:
    """Of the arrays of an earlier state those of the points that are there now, in the present order.

    Points are known by `identity`; states without it have the same points. What is no array stays as it is.
    """
    if "identity" not in before or "identity" not in now:
        return before
    if len(before["identity"]) == len(now["identity"]) and (before["identity"] == now["identity"]).all():
        return before
    order = np.argsort(before["identity"], kind="stable")
    index = order[np.searchsorted(before["identity"], now["identity"], sorter=order)]
    count = len(before["identity"])
    return {
        name: values[index] if isinstance(values, np.ndarray) and len(values) == count else values
        for name, values in before.items()
    }
