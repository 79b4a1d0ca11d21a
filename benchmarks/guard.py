"""What the alarms cost: seconds in the guard, and in the survey that it looks at, over those of the whole."""

import time

from taichi_silo.runs.observers.guard import EVERY_PERIODS, Guard
from taichi_silo.simulation.simulation import Simulation

ROUNDS = 2  # of looks at all points


class Timed:
    """A function whose calls are timed."""

    def __init__(self, function):
        self.function, self.seconds = function, 0.0

    def __call__(self, *given):
        """Call it."""
        begun = time.perf_counter()
        found = self.function(*given)
        self.seconds += time.perf_counter() - begun
        return found


def cost(simulation: Simulation, speed_m_per_s: float = 0.002) -> dict:
    """Of flow with a state of stress already there.

    Returns
    -------
    steps: that were done; seconds: of all of it; guard, survey: parts of that.

    """
    guard = Guard()
    guard.begin(simulation)
    plate = (-speed_m_per_s, -speed_m_per_s)
    simulation.advance(simulation.interval, plate_velocity=plate)  # compiles
    guard.filled()
    simulation.stage, simulation.flow_start = "flow", simulation.time
    observe, survey = Timed(guard.observe), Timed(simulation.solver.point_sums)
    simulation.solver.point_sums = survey
    steps, begun = simulation.steps, time.perf_counter()
    for _ in range(ROUNDS * EVERY_PERIODS * simulation.rows_per_period):
        observe(simulation.advance(simulation.interval, plate_velocity=plate))
    whole = time.perf_counter() - begun
    del simulation.solver.point_sums
    return {
        "steps": simulation.steps - steps, "seconds": whole, "guard": observe.seconds / whole,
        "survey": survey.seconds / whole,
    }  # fmt: skip
