"""Which moments of a run the frames of a film show."""

import itertools
from typing import NamedTuple

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.runs.film_states import FilmStates
from taichi_silo.runs.observers.film_recorder import FRAMES
from taichi_silo.runs.result import Result
from taichi_silo.show.report.words import length_unit

FILLING_SHARE = FRAMES["filling"] / sum(FRAMES.values())


class Moment(NamedTuple):
    """What a frame shows."""

    time_s: float
    stage: str
    progress: float  # on the course [m or s]
    down_m: float | None = None  # how far the bottom has sunk, where that is not the progress
    clock_s: float | None = None  # time that is written, where that is not the run's own

    @property
    def sunk_m(self) -> float:
        """How far the bottom has sunk."""
        return self.progress if self.down_m is None else self.down_m

    @property
    def shown_s(self) -> float:
        """Time that is written."""
        return self.time_s if self.clock_s is None else self.clock_s


class Slow(NamedTuple):
    """A part of the course that is shown more slowly: its ends [m or s], and how many times."""

    begin: float
    end: float
    times: float


def kept(history: Result, states: FilmStates) -> list[Moment]:
    """The moments at which the run has kept the states of its film."""
    return [
        Moment(row["time_s"], row["stage"], history.progress(row))
        for row in states.index.to_dict("records")
        for _ in range(row["shown"])
    ]


def over(history: Result, frames: int) -> list[Moment]:
    """A number of moments: a tenth for the filling, the others even in displacement, or where free in time."""
    filled, end = history.flow_start_s, history.end_s
    flowing = len(history.flow_states) > 0
    before = max(1, round(FILLING_SHARE * frames)) if flowing else frames
    found = [Moment(filled * (k + 1) / before, "filling", 0.0) for k in range(before)]
    if not flowing or frames == before:
        return found
    parts = (np.arange(frames - before) + 1) / (frames - before)
    if history.free:
        times = filled + parts * (end - filled)
    else:
        moved, time = _moved(history)
        times = np.interp(parts * moved[-1], moved, time)
    return found + [_flowing(history, time) for time in times]


def at_speed(history: Result, factor: float, frames_per_second: int) -> list[Moment]:
    """Moments even in time, the sand so many times as fast as it was."""
    count = max(1, int(history.end_s * frames_per_second / factor))
    times = history.end_s * (np.arange(count) + 1) / count
    filled = history.flow_start_s
    return [_flowing(history, t) if t > filled else Moment(float(t), "filling", 0.0) for t in times]


def together(histories: tuple[Result, Result], frames: int) -> list[Moment]:
    """Moments even in time of two runs with one clock, which is 0 when the flow begins; a tenth for the fillings."""
    filled = max(history.flow_start_s for history in histories)
    end = max(history.end_s - history.flow_start_s for history in histories)
    before = max(1, round(FILLING_SHARE * frames)) if end > 0.0 else frames
    found = [Moment(filled * ((k + 1) / before - 1.0), "filling", 0.0) for k in range(before)]
    rest = frames - before
    return found + [Moment(end * (k + 1) / rest, "flow", end * (k + 1) / rest) for k in range(rest)]


def together_at_speed(histories: tuple[Result, Result], factor: float, frames_per_second: int) -> list[Moment]:
    """The same, the sand so many times as fast as it was."""
    filled = max(history.flow_start_s for history in histories)
    end = max(history.end_s - history.flow_start_s for history in histories)
    count = max(1, int((filled + end) * frames_per_second / factor))
    times = (filled + end) * (np.arange(count) + 1) / count - filled
    return [Moment(float(t), "flow" if t > 0.0 else "filling", max(0.0, float(t))) for t in times]


def slowed(shown: list[Moment], slow: Slow) -> list[Moment]:
    """The moments of a film of which a part of the flow lasts so many times as long.

    Between two moments time, progress and the bottom go on evenly.
    """
    middle = [0.5 * (a.progress + b.progress) for a, b in itertools.pairwise(shown)]
    inside = [slow.begin <= place <= slow.end and b.stage == "flow" for place, b in zip(middle, shown[1:], strict=True)]
    lasts = np.concatenate([[0.0], np.cumsum(np.where(inside, slow.times, 1.0))])
    ticks = np.arange(int(lasts[-1] + 1e-9) + 1)
    time, progress = (np.interp(ticks, lasts, [getattr(m, name) for m in shown]) for name in ("time_s", "progress"))
    later = np.searchsorted(lasts, ticks - 1e-9)
    return [Moment(float(t), shown[k].stage, float(p)) for t, p, k in zip(time, progress, later, strict=True)]


def sunk(history: Result, time_s: float) -> float:
    """How far the bottom or the outlet has moved at a time [m]."""
    return float(np.interp(time_s, *_moved(history)[::-1]))


def _moved(history: Result) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of the flow that grow [m], and their times [s]."""
    rows = history.snapshots.iloc[history.flow_states]
    moved = np.concatenate([[0.0], rows["displacement_m"].to_numpy(float)])
    return np.maximum.accumulate(moved), np.concatenate([[history.flow_start_s], rows["time_s"].to_numpy(float)])


def _flowing(history: Result, time: float) -> Moment:
    progress = time - history.flow_start_s if history.free else sunk(history, time)
    return Moment(float(time), "flow", float(progress))


def nearest(history: Result, progress: float) -> int:
    """The row of the index nearest to a place on the course [m or s].

    Raises
    ------
    BadInput
        if the run has not come there.

    """
    places = np.array([history.progress(row) for row in history.snapshots.to_dict("records")])
    if not 0.0 <= progress <= places.max() * (1.0 + 1e-6) + 1e-9:
        unit, scale = ("s", 1.0) if history.free else length_unit(places.max())
        raise BadInput(f"frame is {scale * progress:g} {unit}; it must be from 0 to {scale * places.max():g} {unit}")
    distance = np.abs(places - progress)
    return int(np.flatnonzero(distance <= distance.min() + 1e-12)[-1])  # at 0 the state after filling
