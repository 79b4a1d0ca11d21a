"""Where a rising function is 0: by halving, which needs no library; SciPy's takes a tenth of a second to import."""

from collections.abc import Callable


def root(rising: Callable[[float], float], low: float, high: float) -> float:
    """The place between `low`, where a rising function is below 0, and `high`, to the last digit."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if rising(middle) < 0.0 else (low, middle)
    return middle
