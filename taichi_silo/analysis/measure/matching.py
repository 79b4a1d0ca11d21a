"""Points of an earlier state that are still there in a later one."""

import numpy as np


def matched(before: dict, now: dict) -> dict:
    """Return the earlier state, restricted to the points that are there now, in the present order.

    Both are dictionaries of arrays with a row for each point; `identity` says which point a row is. States without it
    have the same points. Values that are not such arrays are kept.
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
