"""One alarm: what was found wrong when and where, why it may be, and what to do."""

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.simulation.clock import Clock


@dataclass(frozen=True)
class Alarm:
    """What a check has found.

    Attributes
    ----------
    name : of the check.
    stops : whether the run ends with it; else it goes on, and the alarm is a warning.
    what, cause, remedy : parts of one sentence; "{place}" in `what` stands for where it is.
    value, limit : what was found, and what would have been right.
    time_s, stage, displacement_m : when.
    x_m, y_m : where, in the silo; None if it is nowhere in particular.
    point : identity of the material point that is concerned; None if it is none in particular.
    times : how often it was found.
    last_time_s : when it was found the last time.

    """

    name: str
    stops: bool
    what: str
    cause: str
    remedy: str
    value: float
    limit: float
    time_s: float = 0.0
    stage: str = ""
    displacement_m: float = 0.0
    x_m: float | None = None
    y_m: float | None = None
    point: int | None = None
    times: int = 1
    last_time_s: float = 0.0

    def at(self, place_m: np.ndarray, point: int) -> "Alarm":
        """The alarm at a place (x, y) and a point; a place that is no number is none."""
        x, y = (float(value) if np.isfinite(value) else None for value in place_m)
        return dataclasses.replace(self, x_m=x, y_m=y, point=int(point))

    @property
    def sentence(self) -> str:
        """All of it, in words."""
        place = ""
        if self.x_m is not None and self.y_m is not None:
            place = f" near x = {1e3 * self.x_m:.1f} mm, y = {1e3 * self.y_m:.1f} mm"
        if self.point is not None:
            place += f" (point {self.point})"
        when = f"at t = {self.time_s:.4f} s ({self.stage}, u = {1e3 * self.displacement_m:.3f} mm)"
        return f"{when} {self.what.replace('{place}', place)}; {self.cause}; {self.remedy}"


class Alarms:
    """All alarms of a run, one of each name: the first, and how often it came.

    Parameters
    ----------
    kept : what `state` gave, to go on from.

    """

    def __init__(self, kept: Iterable[dict] = ()):
        names = {field.name for field in dataclasses.fields(Alarm)}
        alarms = [Alarm(**{name: value for name, value in one.items() if name in names}) for one in kept]
        self.found: dict[str, Alarm] = {alarm.name: alarm for alarm in alarms}

    def enter(self, alarm: Alarm, clock: Clock) -> bool:
        """Enter an alarm of this time; whether it is the first of its name.

        Raises
        ------
        RunFailed
            if it stops the run.

        """
        first = self.found.get(alarm.name)
        if first is not None and not alarm.stops:
            self.found[alarm.name] = dataclasses.replace(first, times=first.times + 1, last_time_s=clock.time)
            return False
        alarm = dataclasses.replace(
            alarm, time_s=clock.time, stage=clock.stage, displacement_m=clock.displacement, last_time_s=clock.time
        )
        self.found[alarm.name] = alarm
        if alarm.stops:
            raise RunFailed(alarm.sentence)
        return True

    def state(self) -> list[dict]:
        """All of them, as tables; each with its sentence."""
        return [dataclasses.asdict(alarm) | {"sentence": alarm.sentence} for alarm in self.found.values()]
