"""Maxima of a profile that stand out, as `scipy.signal.find_peaks` finds them, with which half a second is imported."""

import numpy as np
from numpy.typing import NDArray


def peaks(profile: NDArray, height: float, prominence: float) -> NDArray:
    """Return the indices of the maxima of a profile (n,) that reach a height and have a prominence at least.

    A maximum is lower on both sides, so none is at an end; of a level stretch its middle counts. Its prominence is its
    rise above the higher one of its two valleys: the lowest values on either side up to where the profile is higher
    than the maximum, or ends.
    """
    steps = np.flatnonzero(np.diff(profile))
    first, last = np.append(0, steps + 1), np.append(steps, len(profile) - 1)  # of each stretch of equal values
    found = []
    for begin, end in zip(first[1:-1], last[1:-1], strict=True):
        top, middle = profile[begin], (begin + end) // 2
        if top < height or profile[begin - 1] >= top or profile[end + 1] >= top:
            continue
        valleys = []
        for side in (profile[middle::-1], profile[middle:]):
            higher = np.flatnonzero(side > top)
            valleys.append(side[: higher[0] if len(higher) else None].min())
        if top - max(valleys) >= prominence:
            found.append(middle)
    return np.array(found, int)
