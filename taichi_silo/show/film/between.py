"""The points of a run at any time, straight between two of the states that are kept.

Points that are in both states move on straight lines, and their values change evenly. Points that leave before the
later state go on with the velocity they had; points that come are there from the later state on.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from taichi_silo.runs.film_states import FilmStates
from taichi_silo.runs.result import Result


class Drawn(NamedTuple):
    """What of a state is drawn."""

    identity: np.ndarray
    position: np.ndarray  # (n, 2) [m]
    velocity: np.ndarray  # (n, 2) [m/s]
    values: np.ndarray


class Between:
    """Positions and values of a field over time; two states at a time are held.

    Parameters
    ----------
    states : that the run has kept: its snapshots, or those of its film.
    values : the field of the points of a state.

    """

    def __init__(self, states: Result | FilmStates, values: Callable[[dict[str, np.ndarray]], np.ndarray]):
        self.kept, self.values = states, values
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
        since = time_s - self.times[number]
        part = since / (self.times[number + 1] - self.times[number])
        position = before.position[here] + part * (after.position[there] - before.position[here])
        values = before.values[here] + part * (after.values[there] - before.values[here])
        falling = before.position[leaving] + since * before.velocity[leaving]
        return np.concatenate([position, falling]), np.concatenate([values, before.values[leaving]])
