"""Has the wall force a limit as the bottom slows? And how fast may it be?"""

from dataclasses import dataclass

import numpy as np

SAME = 0.02  # relative difference of residual forces that counts as none


@dataclass(frozen=True)
class Limit:
    """Limit of N as the bottom slows, from a series of speeds.

    Attributes
    ----------
    slowest_m_per_s : of the series.
    change_per_decade : of N between the two slowest speeds, relative, per factor 10 of the speed; positive where N
        grows as the bottom slows.
    tolerance : what counts as the same: 2 %, or the scatter if it is larger.
    reached : whether the two slowest agree within the tolerance.
    fastest_same_m_per_s : the fastest speed from which on all slower ones agree with the slowest.

    """

    slowest_m_per_s: float
    change_per_decade: float
    tolerance: float
    reached: bool
    fastest_same_m_per_s: float


def limit(speed_m_per_s, normal_N_per_m, scatter: float = 0.0) -> Limit | None:
    """Judge residual N at several speeds; None with fewer than two that are numbers.

    Parameters
    ----------
    speed_m_per_s, normal_N_per_m : of each run.
    scatter : of N between runs that differ by rounding only, relative.

    """
    speed, force = np.asarray(speed_m_per_s, float), np.asarray(normal_N_per_m, float)
    sound = np.isfinite(force)
    order = np.argsort(speed[sound])
    speed, force = speed[sound][order], force[sound][order]
    if len(speed) < 2:
        return None
    tolerance = max(SAME, scatter if np.isfinite(scatter) else 0.0)
    difference = np.abs(force / force[0] - 1.0)
    same = int(np.argmax(difference > tolerance)) - 1 if (difference > tolerance).any() else len(speed) - 1
    return Limit(
        slowest_m_per_s=float(speed[0]),
        change_per_decade=float((1.0 - force[1] / force[0]) / np.log10(speed[1] / speed[0])),
        tolerance=tolerance,
        reached=bool(difference[1] <= tolerance),
        fastest_same_m_per_s=float(speed[same]),
    )


def sentence(name: str, found: Limit) -> str:
    """The limit of a series in words."""
    slow, fast = 1e3 * found.slowest_m_per_s, 1e3 * found.fastest_same_m_per_s
    growth = f"N changes by {100 * found.change_per_decade:+.1f} % a decade at {slow:g} mm/s"
    if found.reached:
        return f"{name}: {growth}; within {100 * found.tolerance:.1f} % it is the same from {fast:g} mm/s down."
    return f"{name}: {growth}; no limit down to {slow:g} mm/s."
