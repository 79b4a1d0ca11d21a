"""The points of a run at any time, straight between two states.

Points that are in both states move on straight lines, and their values change evenly. Points that leave before the
later state go on with the velocity they had; points that come are there from the later state on.
"""

from typing import NamedTuple

import numpy as np

from taichi_silo.runs.point_fields import Field
from taichi_silo.runs.result import Result


class Drawn(NamedTuple):
    """What of a state is drawn."""

    identity: np.ndarray
    position: np.ndarray  # (n, 2) [m]
    velocity: np.ndarray  # (n, 2) [m/s]
    values: np.ndarray


class Between:
    """Places and values of a field over time; two states at a time are held."""

    def __init__(self, history: Result, field: Field):
        self.history, self.field = history, field
        self.times = history.snapshots["time_s"].to_numpy(float)
        self._states: dict[int, Drawn] = {}
        self._pair = None

    def values(self, points: dict[str, np.ndarray]) -> np.ndarray:
        """Of the field, for a state."""
        return self.field.values(points, self.history.start, self.history.scene)

    def state(self, number: int) -> Drawn:
        """A row of the index."""
        if number not in self._states:
            points = self.history.state(number)
            self._states = {n: state for n, state in self._states.items() if abs(n - number) == 1}
            self._states[number] = Drawn(
                points["identity"], points["position"], points["velocity"], self.values(points)
            )
        return self._states[number]

    def at(self, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Places (n, 2) [m] and values (n,) at a time; outside the run, those of its nearest state."""
        number = int(np.searchsorted(self.times, time_s, side="right")) - 1
        if number < 0 or number >= len(self.times) - 1:
            state = self.state(min(max(number, 0), len(self.times) - 1))
            return state.position, state.values
        before, after = self.state(number), self.state(number + 1)
        if self._pair is None or self._pair[0] != number:
            _, here, there = np.intersect1d(before.identity, after.identity, True, return_indices=True)
            self._pair = number, here, there, np.delete(np.arange(len(before.identity)), here)
        _, here, there, leaving = self._pair
        since = time_s - self.times[number]
        part = since / (self.times[number + 1] - self.times[number])
        position = before.position[here] + part * (after.position[there] - before.position[here])
        values = before.values[here] + part * (after.values[there] - before.values[here])
        falling = before.position[leaving] + since * before.velocity[leaving]
        return np.concatenate([position, falling]), np.concatenate([values, before.values[leaving]])
