"""What a step costs, by phase, size and threads, beside a compiled C++ yardstick and the limits of this machine.

`make bench` prints the table, writes outputs/bench/bench.csv and bench.png, and warns where a phase got more than a
tenth slower, relative to the yardstick, than in benchmarks/baseline.csv (`--keep` makes the new table the baseline).
On a machine with a GPU, `--arch cuda` or `--arch vulkan` measures that instead.
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.euler import by_euler
from benchmarks.figure import draw
from benchmarks.guard import cost as cost_of_guard
from benchmarks.roofline import ceilings
from benchmarks.yardstick import Yardstick
from taichi_silo import Flow, Mesh, Scene, Silo, Simulation, Walls
from taichi_silo.api import run
from taichi_silo.mpm import runtime
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.scene.scene import Averaging, cores

ROUNDS = 3
SECONDS = 0.3  # of a measurement
SLOWER = 1.10  # of the baseline's cost over the yardstick's: from there on a warning
WHOLE_RUNS = (  # points, a cell, threads, displacement of the bottom [m]
    (4_000, 1, 1, 0.01), (4_000, 4, 1, 0.01), (4_000, 1, 2, 0.01), (16_000, 1, 1, 0.002), (16_000, 4, 1, 0.002),
    (16_000, 1, 2, 0.002), (16_000, 4, 2, 0.002), (64_000, 1, 2, 0.0005), (64_000, 4, 2, 0.0005),
)  # fmt: skip
BASELINE = Path(__file__).with_name("baseline.csv")
FOLDER = Path("outputs") / "bench"
COLUMNS = (
    "points", "points_per_cell", "threads", "precision", "phase",
    "nanoseconds_per_particle_step", "particle_steps_per_second", "yardstick_ratio", "ratio_with_as_many_a_cell",
)  # fmt: skip
KEY = ["points", "points_per_cell", "threads", "precision", "phase"]


def scene(points: int, points_per_cell: int, threads: int, arch: str = "cpu", cells_of_length: float = 0.0) -> Scene:
    """A silo of 2 : 5 with about so many points; the characteristic length is so many cells, the law local at 0."""
    cells = max(2, round((points / points_per_cell / 10.0) ** 0.5))  # in a tenth of the area
    return Scene(
        silo=Silo(width_m=0.2, height_m=0.5, half="no"),
        walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=0.1 / cells, points_per_cell=points_per_cell),
        averaging=Averaging(characteristic_length_m=cells_of_length * 0.1 / cells),
        flow=Flow(speed_m_per_s=0.002, displacement_m=0.02),
        machine={"arch": arch, "threads": threads},
    )


def loaded(
    points: int, points_per_cell: int, threads: int, control: NoiseControl | None = None, arch: str = "cpu",
    cells_of_length: float = 0.0,
) -> Simulation:  # fmt: skip
    """A silo whose sand bears its weight (geostatic), so that a step is one of quasi-static flow."""
    what = scene(points, points_per_cell, threads, arch, cells_of_length)
    runtime.init(arch, threads)
    simulation = Simulation(what, control)
    particles, at_once = simulation.model.particles, 1 << 16
    stress = particles.fields["stress"]
    for first in range(0, particles.number, at_once):  # large silos have no room for copies
        height = particles.array("position", first, first + at_once)[:, 1]
        vertical = -what.density_kg_per_m3 * 9.81 * (what.silo.height_m - height)
        given = np.stack([0.42 * vertical, vertical, 0.42 * vertical, 0.0 * vertical], axis=1)
        put(stress, given, first + len(given), first)
    particles.revision += 1
    return simulation


def seconds_per_step(advance, seconds: float = SECONDS, rounds: int = ROUNDS) -> float:
    """Median over rounds; the first call compiles."""
    advance(1)
    begun = time.perf_counter()
    advance(20)
    runtime.wait()
    steps = max(20, int(20 * seconds / (time.perf_counter() - begun)))
    times = []
    for _ in range(rounds):
        begun = time.perf_counter()
        advance(steps)
        runtime.wait()
        times.append((time.perf_counter() - begun) / steps)
    return statistics.median(times)


def row(
    size: tuple, phase: str, seconds: float, ratio: float | None = None, alike: float | None = None,
    precision: str = "f64",
) -> dict:  # fmt: skip
    """A line of the table: seconds a step of so many (points, a cell, threads).

    `ratio` is of the yardstick's speed, `alike` of its speed with as many points a cell.
    """
    rate = size[0] / seconds
    return dict(zip(COLUMNS, (
        *size, precision, phase, round(1e9 / rate, 2), round(rate), *(r and round(r, 3) for r in (ratio, alike)),
    ), strict=True))  # fmt: skip


def rates(yardstick: Yardstick | None, size: tuple) -> tuple[float, float]:
    """Of the yardstick [particle-steps a second]: with its 4 points a cell, and with as many as here; 0 without it."""
    if yardstick is None:
        return 0.0, 0.0
    points, per_cell, threads = size
    usual = yardstick.rate(threads, points)
    if per_cell == 4:
        return usual, usual
    return usual, yardstick.rate(threads, points, per_cell) if per_cell in yardstick.programs else 0.0


def ratios(size: tuple, seconds: list[float], theirs: list[tuple[float, float]]) -> tuple[float | None, float | None]:
    """Medians of what was measured in turns, as `row` takes them."""
    usual, alike = (
        statistics.median(size[0] / mine / rate if rate else 0.0 for mine, rate in zip(seconds, column, strict=True))
        for column in zip(*theirs, strict=True)
    )
    return usual or None, alike or None


def measure(
    points: int, points_per_cell: int, threads: int, yardstick: Yardstick | None, phases: bool = True,
    cells_of_length: float = 0.0,
) -> list[dict]:  # fmt: skip
    """The whole step, in turns with the yardstick, and on one thread its phases if they are asked for."""
    simulation = loaded(points, points_per_cell, threads, cells_of_length=cells_of_length)
    size = simulation.scene.points, points_per_cell, threads
    dt = 0.5 * simulation.solver.point_sums().stable_step

    def step(steps: int) -> None:
        simulation.solver.advance(steps, dt, gravity=(9.81, 9.81))

    mine, theirs = [], []
    for _ in range(ROUNDS):  # in turns: the machine's speed drifts
        mine.append(seconds_per_step(step, rounds=1))
        theirs.append(rates(yardstick, size))
    rows = [row(size, "step", statistics.median(mine), *ratios(size, mine, theirs))]
    if threads == 1 and phases:
        from benchmarks.phases import Phases

        for phase, kernel in Phases(simulation.solver).all().items():
            cost = seconds_per_step(lambda n, kernel=kernel: kernel(n, dt))
            rows.append(row(size, phase, cost, *ratios(size, [cost] * ROUNDS, theirs)))
    return rows


def whole_run(
    points: int, points_per_cell: int, threads: int, displacement_m: float, film: bool, yardstick: Yardstick | None
) -> dict:
    """`mass_flow` with all that belongs to it (observers, output, film): wall time over points and steps."""
    what = scene(points, points_per_cell, threads)
    what = what.model_copy(update={"flow": Flow(speed_m_per_s=0.005, displacement_m=displacement_m)})
    size = what.points, points_per_cell, threads
    theirs = [rates(yardstick, size)]
    with tempfile.TemporaryDirectory() as folder:
        summary = run(what, Path(folder) / "run", film=film, progress=False).summary["cost"]
    theirs.append(rates(yardstick, size))  # the machine's speed drifts
    seconds = summary["wall_seconds"] / summary["steps"]
    return row(size, "whole run with film" if film else "whole run", seconds, *ratios(size, [seconds] * 2, theirs))


def alarms(points: int) -> dict:
    """Cost of the alarms beside everything else that a step takes."""
    simulation = loaded(points, 1, 1)
    found = cost_of_guard(simulation)
    print(
        f"{simulation.scene.points:9,d} points: the guard takes {found['guard']:.2%} of a run's stepping, the sums "
        f"over the points that it and the choice of the step look at {found['point_sums']:.2%}", flush=True,
    )  # fmt: skip
    return row((simulation.scene.points, 1, 1), "guard", found["guard"] * found["seconds"] / found["steps"])


def averages(points: int) -> list[dict]:
    """The non-local average on one thread: a step's means, and building them once."""
    from benchmarks.phases import Averages
    from taichi_silo.mpm.grid_means import GridMeans
    from taichi_silo.mpm.neighbour_rows import NeighbourRows
    from taichi_silo.mpm.nonlocal_average import Gaussian

    rows = []
    for ratio in (1.0, 2.0, 4.0):  # l_c over the spacing
        simulation = loaded(points, 1, 1)
        particles, grid, spacing = simulation.model.particles, simulation.model.grid, simulation.model.spacing
        kernel, size = Gaussian(ratio * spacing), (simulation.scene.points, 1, 1)
        for by, means in (
            ("rows", NeighbourRows(kernel, particles, spacing)), ("grid", GridMeans(kernel, particles, grid)),
        ):  # fmt: skip
            means.build()
            of_step = seconds_per_step(Averages(means).steps)
            anew = seconds_per_step(lambda n, m=means: [m.build() for _ in range(n)], seconds=0.1, rounds=3)
            rows += [row(size, f"average by {by}, l_c {ratio:.0f}", of_step)]
            rows += [row(size, f"{by} anew, l_c {ratio:.0f}", anew)]
    return rows


def sizes(threads: int) -> list[dict]:
    """Cost of a step from 1,000 to 1,000,000 points, each in a process of its own (`scale` measures memory)."""
    rows = []
    for points in (1_000, 10_000, 100_000, 1_000_000):
        code = (
            "from benchmarks.bench import loaded, seconds_per_step; "
            f"s = loaded({points}, 1, {threads}); dt = 0.5 * s.solver.point_sums().stable_step; "
            "print(s.scene.points, "
            "seconds_per_step(lambda k: s.solver.advance(k, dt, gravity=(9.81, 9.81)), rounds=3))"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        count, seconds = map(float, done.stdout.split()[-2:])
        rows.append(row((int(count), 1, threads), "size", seconds))
        say(rows[-1:])
    return rows


def start() -> float:
    """Seconds from the start of Python until a silo is ready, with what was compiled before (warm)."""
    code = "from benchmarks.bench import loaded; loaded(4000, 1, 1)"
    times = []
    for _ in range(3):
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
        times.append(time.perf_counter() - begun)
    return min(times)


def on_gpu(arch: str) -> list[dict]:
    """Large and small scenes on the graphics card."""
    rows = []
    for points in (4_000, 64_000, 1_000_000, 4_000_000):
        for per_cell in (1, 4):
            simulation = loaded(points, per_cell, 1, arch=arch)
            dt = 0.5 * simulation.solver.point_sums().stable_step
            cost = seconds_per_step(lambda n, s=simulation, dt=dt: s.solver.advance(n, dt, gravity=(9.81, 9.81)))
            rows.append(row((simulation.scene.points, per_cell, 0), "step", cost, precision=runtime.PRECISION))
            say(rows[-1:])
    return rows


def say(rows: list[dict]) -> None:
    """Print lines of the table."""
    for line in rows:
        ratio = f"{line['yardstick_ratio']:.2f} of the yardstick" if line["yardstick_ratio"] else ""
        if line["ratio_with_as_many_a_cell"] and line["points_per_cell"] != 4:
            ratio += f", {line['ratio_with_as_many_a_cell']:.2f} of it with as many a cell"
        print(
            f"{line['points']:9,d} points, {line['points_per_cell']} a cell, {line['threads']} thread(s)  "
            f"{line['phase']:22s} {line['nanoseconds_per_particle_step']:9.1f} ns  "
            f"{line['particle_steps_per_second'] / 1e6:8.2f} M/s  {ratio}", flush=True,
        )  # fmt: skip


def slower(table: pd.DataFrame, baseline: pd.DataFrame) -> list[str]:
    """Sentences on what costs over a tenth more than in the baseline, both over the yardstick's cost."""
    both = table.merge(baseline, on=KEY, suffixes=("", "_before"))
    lost = both[both.yardstick_ratio * SLOWER < both.yardstick_ratio_before]
    return [
        f"{one.points} points, {one.points_per_cell} a cell, {one.threads} thread(s), {one.phase}: "
        f"{one.yardstick_ratio:.2f} of the yardstick, it was {one.yardstick_ratio_before:.2f}"
        for one in lost.itertuples()
    ]


def main() -> None:
    """Measure, print, write, draw, warn."""
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--arch", choices=runtime.ARCHITECTURES, default="cpu")
    flags.add_argument("--keep", action="store_true", help="make the new table the baseline")
    chosen = flags.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    if chosen.arch != "cpu":
        file = FOLDER / f"bench_{chosen.arch}_{runtime.PRECISION}.csv"
        pd.DataFrame(on_gpu(chosen.arch), columns=COLUMNS).to_csv(file, index=False)
        return
    yardstick = Yardstick.find()
    print("yardstick:", "compiled C++, measured in turns" if yardstick else "not found; absolute figures")
    rows = []
    for points in (4_000, 16_000, 64_000):
        for per_cell in (1, 4):
            for threads in (1, 2) if cores() > 1 else (1,):
                rows += measure(points, per_cell, threads, yardstick)
                say(rows[-1 if threads > 1 else -5 :])
            with by_euler():
                (of_step,) = measure(points, per_cell, 1, yardstick, phases=False)
            rows.append(of_step | {"phase": "step by Euler's rule"})
            say(rows[-1:])
    for length in (1, 4):
        (of_step,) = measure(16_000, 1, 1, yardstick, phases=False, cells_of_length=length)
        rows.append(of_step | {"phase": f"step, l_c {length}"})
        say(rows[-1:])
    for size in WHOLE_RUNS:
        for film in (False, True) if size == WHOLE_RUNS[0] else (False,):
            rows.append(whole_run(*size, film, yardstick))
            say(rows[-1:])
    rows += [alarms(points) for points in (1_000, 4_000, 16_000, 64_000)]
    rows += (added := averages(16_000))
    say(added)
    rows += sizes(1)
    print(f"start-up, warm: {start():.1f} s")
    table = pd.DataFrame(rows, columns=COLUMNS)
    table.to_csv(FOLDER / "bench.csv", index=False)
    draw(table, ceilings(), FOLDER / "bench.png")
    print(f"written to {FOLDER / 'bench.csv'} and {FOLDER / 'bench.png'}")
    if BASELINE.exists():
        for words in slower(table, pd.read_csv(BASELINE)):
            print(f"warning: {words}")
    if chosen.keep:
        table.to_csv(BASELINE, index=False)


if __name__ == "__main__":
    main()
