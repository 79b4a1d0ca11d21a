"""What long runs do: drift, memory, and a silo that is emptied and filled again: `make endurance`.

slow
    The paper's case (dense sand, very rough walls) at its own 0.1 mm/s, for as long as the given minutes allow.
memory
    A million steps of a small silo, with everything that a run leaves: the memory of the process.
refill
    A silo without floor is emptied by gravity to the last point, and filled again, twice.

Prints a table and writes outputs/endurance/endurance.csv. Cost: the given minutes, and some three more, on one core.
"""

import contextlib
import copy
import json
import resource
import sys
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from typer import Option

from taichi_silo.api import run
from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput, Stopped
from taichi_silo.mpm import runtime
from taichi_silo.runs.observers import Observer
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Scene, Walls
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.simulation.simulation import Simulation

FOLDER = Path("outputs") / "endurance"
PARTS = ("slow", "memory", "refill")
STEPS, WARM = 1_000_000, 100_000  # of the memory's run, and those before the first look
LOOKS = 10_000  # steps between two looks
CYCLES = 3


class Deadline(Observer):
    """Stops a run after some seconds."""

    def __init__(self, seconds: float):
        self.end_s = time.monotonic() + seconds

    def observe(self, record) -> None:
        """Look at the clock."""
        if time.monotonic() > self.end_s:
            raise Stopped("the time is over", 0)


class Memory(Observer):
    """Memory of the process [MiB] against steps; stops a run after a number of them."""

    def __init__(self, steps: int | None = None):
        self.steps, self.seen = steps, []

    def begin(self, simulation) -> None:
        """Know whose steps are counted."""
        self.simulation = simulation

    def observe(self, record) -> None:
        """Look now and then."""
        steps = self.simulation.clock.steps
        if not self.seen or steps >= self.seen[-1][0] + LOOKS:
            self.seen.append((steps, resident_MiB()))
        if self.steps is not None and steps >= self.steps:
            raise Stopped("all steps are done", 0)

    def growth(self, warm: int) -> float:
        """Growth from the first look after so many steps to the largest later one, over the first."""
        later = [size for steps, size in self.seen if steps >= warm]
        return max(later) / later[0] - 1.0


def resident_MiB() -> float:
    """Memory of this process now; where the system does not tell, the most so far."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def stopped(scene: Scene, folder: Path, *extra: Observer, film: bool = True) -> dict:
    """Run until an observer stops it; what the summary says."""
    with contextlib.suppress(Stopped):
        run(scene, folder, overwrite=True, film=film, progress=False, extra=extra)
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def slow(folder: Path, minutes: float) -> dict:
    """Measures of the paper's case at 0.1 mm/s."""
    memory = Memory()
    scene = Scene(flow=Flow(speed_m_per_s=1e-4), machine=Machine(threads=1))
    found = stopped(scene, folder / "slow", memory, Deadline(60.0 * minutes))
    simulation, certificate = memory.simulation, found["certificate"]
    points = simulation.points()
    return {
        "minutes": minutes,
        "steps": simulation.clock.steps,
        "displacement_mm": 1e3 * simulation.displacement,
        "error of mass / mass": abs(points["mass"].sum() / simulation.model.mass - 1.0),
        "largest balance residual / W": certificate["force_balance_residual_over_weight"],
        "void ratio lost without shear": certificate.get("unexplained_densification", 0.0),
        "share of sand without shear": certificate.get("unsheared_share", 0.0),
        "noise of N": certificate.get("noise_of_normal_force", 0.0),
        "growth of memory": memory.growth(WARM),
        "alarms": len(simulation.alarms.found),
    }


def million(folder: Path, steps: int = STEPS) -> dict:
    """Growth of memory in a run of a small silo."""
    scene = Scene(
        silo=Silo(height_m=0.4), grid=Mesh(cell_size_m=0.05), walls=Walls(kind="smooth", friction_angle_deg=19.0),
        flow=Flow(speed_m_per_s=1e-5, displacement_m=0.1), machine=Machine(threads=1, lanes=False),
        method=Method(filling_time_s=0.1, longest_settling_s=0.1),
    )  # fmt: skip
    memory = Memory(steps)
    stopped(scene, folder / "memory", memory)
    return {
        "steps": memory.simulation.clock.steps,
        "MiB after a tenth": next(m for s, m in memory.seen if s >= 0.1 * steps),
        "MiB at the end": memory.seen[-1][1], "growth of memory": memory.growth(steps // 10),
    }  # fmt: skip


def refill(cell_size_m: float = 0.01, cycles: int = CYCLES) -> dict:
    """Fill, empty by gravity, and fill again: what is left, what the books say, and whether the fills are the same."""
    scene = Scene(
        silo=Silo(width_m=0.2, height_m=0.2, outlet=Outlet(width_m=0.18)),
        walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=cell_size_m), flow=Flow(outflow="gravity", displacement_m=10.0, longest_s=4.0),
        machine=Machine(threads=1),
    )  # fmt: skip
    scene.machine.start()
    simulation, forces, errors, left, rest = Simulation(scene), [], [], [], []
    empty = copy.deepcopy(simulation.state())
    for _ in range(cycles):
        simulation.restore(empty)
        records = list(simulation.fill())
        forces.append([(r.normal_N_per_m, r.shear_N_per_m, r.bottom_N_per_m) for r in records])
        records += simulation.flow()
        weight = simulation.model.mass * simulation.model.gravity
        rest.append(max(abs(r.residual_N_per_m) for r in records) / weight)
        gone = simulation.discharged
        errors.append(abs(gone + simulation.held_mass - simulation.model.mass) / simulation.model.mass)
        left.append(int(simulation.model.particles.active[None]))
    same = all(len(one) == len(forces[0]) and np.array_equal(one, forces[0]) for one in forces)
    return {
        "fills": cycles, "points": simulation.model.particles.count, "points left, at most": max(left),
        "error of the books / mass": max(errors), "largest balance residual / W": max(rest),
        "fills alike bit by bit": same,
    }  # fmt: skip


def endurance(
    minutes: Annotated[float, Option(help="of the slow part [min]")] = 30.0,
    part: Annotated[str, Option(help=" | ".join((*PARTS, "all")))] = "all",
    output: Annotated[Path, Option(help="folder of the table and the runs")] = FOLDER,
):
    """Run long, and say what has drifted."""
    if part not in (*PARTS, "all"):
        raise BadInput(f"part is {part}; it must be one of {', '.join((*PARTS, 'all'))}")
    if not 0.0 < minutes <= 1e4:
        raise BadInput(f"minutes is {minutes}; it must be above 0 and at most 10000")
    rows = []
    for name, measure in (
        ("refill", refill), ("memory", lambda: million(output)), ("slow", lambda: slow(output, minutes)),
    ):  # fmt: skip
        if part in (name, "all"):
            runtime.init()
            found = measure()
            rows += [(name, what, value) for what, value in found.items()]
            for what, value in found.items():
                print(f"{name:8s} {what:34s} {value if isinstance(value, bool | int) else f'{value:.4g}'}")
    output.mkdir(parents=True, exist_ok=True)
    table = pd.DataFrame(rows, columns=["part", "measure", "value"])
    table.to_csv(output / "endurance.csv", index=False)


if __name__ == "__main__":
    command_line.command(endurance)
