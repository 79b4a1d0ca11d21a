"""A whole run of few steps, with all that looks at it, and what memory it holds at each stage; on Linux.

    python -m benchmarks.whole_run POINTS FOLDER

prints the number of points, and for each stage its name, the bytes held after it and the most within it. Stages are
those of a run; only the intervals between records are a few steps long, and a band of the sand counts as sheared, so
that there is a shear zone to be measured at the end.
"""

import sys
from pathlib import Path

import numpy as np

from benchmarks.bench import loaded
from taichi_silo.mpm.field_memory import put
from taichi_silo.runs import session
from taichi_silo.runs.observers.film_recorder import FilmRecorder
from taichi_silo.runs.observers.guard import EVERY_PERIODS
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.simulation.clock import Interval
from taichi_silo.simulation.simulation import Simulation

STEPS = 3  # of an interval
SHARES = (0.02, 0.5, 0.92, 1.0)  # of the displacement, at the records of the flow
BAND = 0.06  # of the width, of the sheared sand: its standard deviation


def said(name: str) -> int:
    """Of the memory of this process [bytes]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name):
            return 1024 * int(line.split()[1])
    raise LookupError(name)


def show(stage: str) -> None:
    """Print what is held now, and the most since the last time."""
    print(stage, said("VmRSS"), said("VmHWM"), flush=True)
    Path("/proc/self/clear_refs").write_text("5")  # the greatest from now on


def advance(simulation: Simulation, share: float = 0.0):
    """A record after some steps, at which so much of the displacement counts as done."""
    sums, flow = simulation.sums or simulation.solver.point_sums(), simulation.scene.flow
    simulation.clock.displacement = share * flow.displacement_m
    way = -0.01 * flow.speed_m_per_s if share else 0.0
    return simulation.advance(Interval(0.9 * STEPS * sums.stable_step, plate_velocity=(way, way)))


def shear(simulation: Simulation) -> None:
    """Have a band of sand sheared that crosses the silo."""
    particles, silo = simulation.model.particles, simulation.scene.silo
    x, y = particles.present("position").T
    away = (y - 0.5 * silo.height_m - 0.4 * (x - 0.5 * silo.width_m)) / (BAND * silo.width_m)
    put(particles.fields["path"], np.exp(-0.5 * away**2), particles.number)
    simulation.solver.executor.lend()


def main() -> None:
    """Do the run."""
    points, folder = int(sys.argv[1]), Path(sys.argv[2])
    simulation = loaded(points, 1, 1)
    session.Simulation = lambda scene: simulation
    one = session._Session(simulation.scene, folder, {"film": FilmRecorder(folder / "film_states.bin")}, ())
    observers, guard = [*one.observers.values(), one.checkpoint], one.observers["guard"]
    print(simulation.scene.points)
    show("ready")
    write_parameters(folder, simulation.scene, {})
    for observer in observers:
        observer.begin(simulation)
    show("begun")

    def interval(share: float = 0.0) -> None:
        record = advance(simulation, share)
        show("steps")
        guard.count = EVERY_PERIODS * simulation.scene.output.records_per_period - 1  # all points are looked at
        for observer in observers:
            observer.observe(record)
        show("looks")

    interval()
    for observer in observers:
        observer.filled()
    show("filled")
    simulation.clock.begin_flow()
    shear(simulation)
    for share in SHARES:
        interval(share)
    one.checkpoint.write()
    show("checkpoint")
    for observer in observers:
        observer.end()
    show("end")
    if lacking := [told for told in one.summary.found.get("warnings", []) if "could not be measured" in told]:
        raise RuntimeError(" ".join(lacking))


if __name__ == "__main__":
    main()
