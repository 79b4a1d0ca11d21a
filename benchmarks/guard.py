"""What the alarms cost: seconds in the guard, and in the sums over the points that it looks at, over the whole."""

import time
from collections.abc import Callable

from taichi_silo.runs.observers.guard import EVERY_PERIODS, Guard
from taichi_silo.simulation.clock import Interval
from taichi_silo.simulation.simulation import Simulation

ROUNDS = 2  # of looks at all points


def cost(simulation: Simulation, speed_m_per_s: float = 0.002) -> dict[str, float]:
    """Cost of the guard in flow, of a simulation with a state of stress already there.

    Returns
    -------
    steps: that were done; seconds: of all of it; guard, point_sums: parts of that.

    """
    spent = dict.fromkeys(("guard", "point_sums"), 0.0)

    def timed(name: str, function: Callable) -> Callable:
        def call(*given):
            begun = time.perf_counter()
            found = function(*given)
            spent[name] += time.perf_counter() - begun
            return found

        return call

    guard = Guard()
    guard.begin(simulation)
    interval = Interval(simulation.model.interval, plate_velocity=(-speed_m_per_s, -speed_m_per_s))
    simulation.advance(interval)  # compiles
    guard.filled()
    simulation.clock.begin_flow()
    observe = timed("guard", guard.observe)
    sums = simulation.solver.sums
    sums.read = timed("point_sums", sums.read)
    steps, begun = simulation.clock.steps, time.perf_counter()
    for _ in range(ROUNDS * EVERY_PERIODS * simulation.scene.output.records_per_period):
        observe(simulation.advance(interval))
    whole = time.perf_counter() - begun
    del sums.read
    steps = simulation.clock.steps - steps
    return {"steps": steps, "seconds": whole} | {name: part / whole for name, part in spent.items()}
