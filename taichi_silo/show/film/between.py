"""The points of a run at any time, straight between two of the states that are kept.

Points that are in both states move on straight lines, and their values change evenly. Points that leave before the
later state go on with the velocity they had, or through the opening where there is one, ever faster, so that they are
below the picture by then; points that come are there from the later state on.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from taichi_silo.runs.film_states import FilmStates
from taichi_silo.runs.result import Result

GRAVITY = 9.81  # [m/s2]


class Drawn(NamedTuple):
    """What of a state is drawn."""

    identity: np.ndarray
    position: np.ndarray  # (n, 2) [m]
    velocity: np.ndarray  # (n, 2) [m/s]
    values: np.ndarray


class Way(NamedTuple):
    """Where sand leaves: the left and the right edge of the opening, and the height at which it is out of sight [m]."""

    left: float
    right: float
    below: float


class Between:
    """Positions and values of a field over time; two states at a time are held.

    Parameters
    ----------
    states : that the run has kept: its snapshots, or those of its film.
    values : the field of the points of a state.
    way : where sand leaves; None: it goes on with the velocity it had.

    """

    def __init__(
        self, states: Result | FilmStates, values: Callable[[dict[str, np.ndarray]], np.ndarray], way: Way | None = None
    ):
        self.kept, self.values, self.way = states, values, way
        table = states.index if isinstance(states, FilmStates) else states.snapshots
        self.times = table["time_s"].to_numpy(float)
        self._states: dict[int, Drawn] = {}
        self._pair: tuple[int, np.ndarray, np.ndarray, np.ndarray] | None = None

    def state(self, number: int) -> Drawn:
        """A row of the index."""
        if number not in self._states:
            points = self.kept.state(number)
            self._states = {n: state for n, state in self._states.items() if abs(n - number) == 1}
            self._states[number] = Drawn(
                points["identity"], points["position"], points["velocity"], self.values(points)
            )
        return self._states[number]

    def at(self, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 2) [m] and values (n,) at a time; outside the run, those of its nearest state."""
        number = int(np.searchsorted(self.times, time_s, side="right")) - 1
        number = min(max(number, 0), len(self.times) - 1)
        if time_s <= self.times[number] or number == len(self.times) - 1:
            state = self.state(number)
            return state.position, state.values
        before, after = self.state(number), self.state(number + 1)
        if self._pair is None or self._pair[0] != number:
            _, here, there = np.intersect1d(before.identity, after.identity, True, return_indices=True)
            self._pair = number, here, there, np.delete(np.arange(len(before.identity)), here)
        _, here, there, leaving = self._pair
        since, whole = time_s - self.times[number], self.times[number + 1] - self.times[number]
        part = since / whole
        position = before.position[here] + part * (after.position[there] - before.position[here])
        values = before.values[here] + part * (after.values[there] - before.values[here])
        falling = fallen(before.position[leaving], before.velocity[leaving], since, whole, self.way)
        return np.concatenate([position, falling]), np.concatenate([values, before.values[leaving]])


def fallen(position: np.ndarray, velocity: np.ndarray, since: float, whole: float, way: Way | None) -> np.ndarray:
    """Positions (n, 2) [m] of points that leave within a time.

    Parameters
    ----------
    position, velocity : (n, 2) of the points at its begin [m, m/s].
    since, whole : how long after that, and how long it is [s].
    way : where sand leaves; None: it goes on with the velocity it had.

    """
    straight = position + since * velocity
    if way is None:
        return straight
    end = position[:, 1] + whole * velocity[:, 1]
    pull = np.maximum(0.5 * GRAVITY, (end - way.below) / whole**2)  # [m/s2], halved: enough to be out of sight in time
    height = straight[:, 1] - pull * since**2
    target = np.clip(position[:, 0] + whole * velocity[:, 0], way.left, way.right)
    return np.column_stack([position[:, 0] + since / whole * (target - position[:, 0]), height])
