"""What a step costs: nanoseconds a point by phase, at 4,000 and 64,000 points, beside a compiled C++ yardstick.

`make bench` prints the table and writes outputs/bench/bench.csv. The yardstick (`mpm2d.cpp`: the same method with
explicit vectorisation, 4 points a cell) is looked for in $TAICHI_SILO_YARDSTICK and in ../shared/yardstick; without it,
or without a C++ compiler, the figures are absolute. Absolute figures move by a third from hour to hour on a shared
machine: quote the ratio, which is measured in turns with the yardstick.
"""

import csv
import os
import re
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from taichi_silo import Flow, Mesh, Scene, Silo, Simulation, Walls, runtime
from taichi_silo.noise import NoiseControl

ROUNDS = 5
SECONDS = 0.6  # of a measurement
COLUMNS = (
    "points", "points_per_cell", "threads", "precision", "phase",
    "nanoseconds_per_particle_step", "particle_steps_per_second", "yardstick_ratio",
)  # fmt: skip


class Yardstick:
    """The C++ program, compiled once; None where it cannot be had."""

    FLAGS = ("-O3", "-march=native", "-mprefer-vector-width=512", "-ffast-math", "-fopenmp", "-std=c++17")

    @classmethod
    def find(cls) -> "Yardstick | None":
        """Compile it if it is there."""
        here = Path(os.environ.get("TAICHI_SILO_YARDSTICK", Path(__file__).parents[2] / "shared" / "yardstick"))
        source = here / "mpm2d.cpp"
        if not source.exists():
            return None
        program = Path(tempfile.mkdtemp()) / "mpm2d"
        try:
            subprocess.run(["g++", *cls.FLAGS, str(source), "-o", str(program)], check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            return None
        return cls(program)

    def __init__(self, program: Path):
        self.program = program

    def rate(self, threads: int, points: int) -> float:
        """Particle-steps per second of the hypoplastic law in f64 at the nearest size it offers."""
        cells = 32 if points < 20_000 else 128
        text = subprocess.run(
            [str(self.program), "f64", str(threads), str(cells)],
            capture_output=True, text=True, check=True, env=os.environ | {"OMP_PROC_BIND": "true"},
        ).stdout  # fmt: skip
        found = re.search(r"GB\s.*?([\d.]+) Mp/s", text)
        return 1e6 * float(found.group(1))


def scene(points: int, points_per_cell: int, threads: int) -> Scene:
    """A silo of 2 : 5 with about so many points."""
    cells = round((points / points_per_cell / 10.0) ** 0.5)  # in a tenth of the area
    h = 0.1 / cells
    return Scene(
        silo=Silo(width_m=0.2, height_m=0.5, half="no"),
        walls=Walls(kind="smooth"),
        grid=Mesh(cell_size_m=h, points_per_cell=points_per_cell),
        flow=Flow(speed_m_per_s=0.002, displacement_m=0.02),
        machine={"arch": "cpu", "threads": threads},
    )


def loaded(points: int, points_per_cell: int, threads: int, control: NoiseControl | None = None) -> Simulation:
    """A silo whose sand bears its weight (geostatic), so that a step is one of quasi-static flow."""
    what = scene(points, points_per_cell, threads)
    runtime.init("cpu", threads)
    simulation = Simulation(what, control)
    arrays = simulation.particles.arrays()
    vertical = -what.density_kg_per_m3 * 9.81 * (what.silo.height_m - arrays["position"][:, 1])
    arrays["stress"] = np.stack([0.42 * vertical, vertical, 0.42 * vertical, 0.0 * vertical], axis=1)
    simulation.particles.load(arrays)
    return simulation


def seconds_per_step(advance) -> float:
    """Median over rounds; the first call compiles."""
    advance(1)
    begun = time.perf_counter()
    advance(20)
    steps = max(20, int(20 * SECONDS / (time.perf_counter() - begun)))
    times = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        advance(steps)
        runtime.wait()
        times.append((time.perf_counter() - begun) / steps)
    return statistics.median(times)


def measure(points: int, points_per_cell: int, threads: int, yardstick: Yardstick | None) -> list[dict]:
    """Rows of the table for one size."""
    simulation = loaded(points, points_per_cell, threads)
    count = simulation.scene.points
    dt = 0.5 * simulation.solver.survey().stable_step
    rows = []

    def row(phase: str, seconds: float, ratio: float | None = None) -> None:
        rows.append(
            {
                "points": count,
                "points_per_cell": points_per_cell,
                "threads": threads,
                "precision": "f64",
                "phase": phase,
                "nanoseconds_per_particle_step": round(1e9 * seconds / count, 2),
                "particle_steps_per_second": round(count / seconds),
                "yardstick_ratio": "" if ratio is None else round(ratio, 3),
            }
        )

    def step(steps: int) -> None:
        simulation.solver.advance(steps, dt, gravity=(9.81, 9.81))

    ratio = None
    mine = seconds_per_step(step)
    if yardstick is not None:
        pairs = []
        for _ in range(ROUNDS):  # in turns: the machine's speed drifts
            theirs = yardstick.rate(threads, count)
            begun = time.perf_counter()
            steps = max(1, int(SECONDS / mine))
            step(steps)
            pairs.append(count * steps / (time.perf_counter() - begun) / theirs)
        ratio = statistics.median(pairs)
    row("step", mine, ratio)
    if threads == 1:
        for phase, cost in phases(simulation, dt).items():
            row(phase, cost)
    return rows


def phases(simulation: Simulation, dt: float) -> dict[str, float]:
    """Seconds a step of each phase, timed alone on the same state (one thread)."""
    from benchmarks.phases import Phases

    alone = Phases(simulation.solver)
    return {name: seconds_per_step(lambda n, run=run: run(n, dt)) for name, run in alone.all().items()}


def averages(points: int) -> list[dict]:
    """Rows of the non-local average on one thread: a step's means, and building all rows once."""
    from benchmarks.phases import Neighbours
    from taichi_silo.averaging import Gaussian, NonLocal

    rows = []
    for ratio in (1.0, 2.0):  # l_c over the spacing
        simulation = loaded(points, 1, 1)
        average = NonLocal(Gaussian(ratio * simulation.spacing), simulation.particles, simulation.spacing)
        average.refresh()
        count = simulation.scene.points
        neighbours = average.pairs / count
        alone = Neighbours(average)
        for phase, seconds in (
            (f"average of {neighbours:.0f}", seconds_per_step(alone.means)),
            (f"rows of {neighbours:.0f} anew", seconds_per_step(lambda n, a=average: [a.build() for _ in range(n)])),
        ):
            rows.append(
                {
                    "points": count, "points_per_cell": 1, "threads": 1, "precision": "f64", "phase": phase,
                    "nanoseconds_per_particle_step": round(1e9 * seconds / count, 2),
                    "particle_steps_per_second": round(count / seconds), "yardstick_ratio": "",
                }
            )  # fmt: skip
            print(
                f"{count:7d} points, 1 thread  {phase:22s} {1e9 * seconds / count:8.1f} ns a point, "
                f"{1e9 * seconds / count / neighbours:6.2f} ns a neighbour", flush=True,
            )  # fmt: skip
    return rows


def main() -> None:
    """Measure, print, write."""
    yardstick = Yardstick.find()
    print("yardstick:", "compiled C++, measured in turns" if yardstick else "not found; absolute figures")
    rows = []
    for points in (4_000, 64_000):
        for points_per_cell in (1, 4):
            for threads in (1, 2) if (os.cpu_count() or 1) > 1 else (1,):
                rows += measure(points, points_per_cell, threads, yardstick)
                for row in rows[-1 if threads > 1 else -5 :]:
                    print(
                        f"{row['points']:7d} points, {row['points_per_cell']} a cell, {row['threads']} thread(s)  "
                        f"{row['phase']:18s} {row['nanoseconds_per_particle_step']:8.1f} ns  "
                        f"{row['particle_steps_per_second'] / 1e6:7.2f} M/s  "
                        + (f"{row['yardstick_ratio']:.2f} of the yardstick" if row["yardstick_ratio"] else ""),
                        flush=True,
                    )
    rows += averages(16_000)
    folder = Path("outputs") / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "bench.csv", "w", newline="") as stream:
        writer = csv.DictWriter(stream, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    print(f"written to {folder / 'bench.csv'}")


if __name__ == "__main__":
    main()
