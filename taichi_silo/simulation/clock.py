"""The time of a simulation: where it stands, and the interval that it is to compute next."""

import math
from dataclasses import dataclass

import numpy as np

from taichi_silo.mpm.walls.outlets import OPENED


@dataclass(frozen=True)
class Interval:
    """What is to happen until the next record.

    Attributes
    ----------
    duration : [s].
    gravity : at the start and the end, linear between [m/s2]; None: that of the scene.
    plate_velocity : of the bottom or the gate at the start and the end, upwards, linear between [m/s].
    growth : factor of the time step, for an interval in which the stress grows.
    longer : how many times as long as in the interval before a time step may be at most.
    poured : indices of points of the fill that come in before it starts; None: none do.
    above : how far above their place in the fill these come in [m].
    gates : speeds of gates that move each at its own time, over that of one that is open.

    """

    duration: float
    gravity: tuple[float, float] | None = None
    plate_velocity: tuple[float, float] = (0.0, 0.0)
    growth: float = 1.0
    longer: float = math.inf
    poured: np.ndarray | None = None
    above: float = 0.0
    gates: tuple[float, ...] = ()

    @property
    def gate_is_open(self) -> bool:
        """Whether nothing bears the sand in the outlet."""
        return self.plate_velocity[0] <= OPENED

    @property
    def hastens(self) -> bool:
        """Whether the bottom or the gate has not got its speed yet."""
        return self.plate_velocity[0] != self.plate_velocity[1]

    @property
    def travel(self) -> float:
        """How far the bottom or the gate moves, upwards [m]."""
        return 0.5 * (self.plate_velocity[0] + self.plate_velocity[1]) * self.duration


@dataclass
class Clock:
    """Where a simulation stands; a checkpoint keeps it as a dictionary.

    Attributes
    ----------
    time : since the start of the filling [s].
    steps : number of time steps until now.
    stage : "filling" or "flow".
    displacement : of the bottom or the gate, downwards [m]; once the gate is open, of one that would have let out as
        much.
    settled : whether the wall force had come to rest before the flow.
    finished : whether the flow has come to its end.
    flow_start : when the flow began [s]; None before.
    left_at : when sand last left the silo, or first could [s].
    step : length of a time step in the last interval [s].
    stepping_seconds : of the machine's time, spent in steps [s].
    ended : why a free outflow has ended, see `outflow.why_ended`; "jam" of any that has jammed; empty of others.

    """

    time: float = 0.0
    steps: int = 0
    stage: str = "filling"
    displacement: float = 0.0
    settled: bool = False
    finished: bool = False
    flow_start: float | None = None
    left_at: float = 0.0
    step: float = math.inf
    stepping_seconds: float = 0.0
    ended: str = ""

    def begin_flow(self) -> None:
        """The filling is over."""
        self.stage, self.flow_start, self.left_at = "flow", self.time, self.time
