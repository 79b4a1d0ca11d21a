"""What a silo of any size takes: memory measured here, seconds from the paces that `make bench` has left.

    memory = process + bytes a point * points
    seconds = nanoseconds a point and step * points * steps / threads

`make scale` prints both for a silo of 6 m x 20 m, and writes outputs/bench/scale.csv and memory.csv.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd

from taichi_silo import Flow, Mesh, Scene, Silo, Walls
from taichi_silo.mpm import runtime
from taichi_silo.runs import cost_estimate

FOLDER = Path("outputs") / "bench"
PACES = Path("outputs") / "gallery" / "bench.csv"
SIZES = (250_000, 1_000_000)
CELLS_M = (0.05, 0.02, 0.01)
GIB = 2.0**30
STEPS = "steps"  # of the stages
COMPILE = """
from benchmarks.bench import loaded
simulation = loaded({points}, 1, 1)
simulation.solver.advance(2, 0.5 * simulation.solver.point_sums().stable_step)
simulation.solver.filter.turn()
"""


def memory(points: int) -> list[dict]:
    """What the process of a run of so many points holds, and the most in each of its stages [bytes]; on Linux."""
    # compiling takes memory of its own
    subprocess.run([sys.executable, "-c", COMPILE.format(points=points)], check=True)
    with tempfile.TemporaryDirectory(dir=FOLDER) as folder:
        program = [sys.executable, "-m", "benchmarks.whole_run", str(points), folder]
        count, *lines = subprocess.run(program, capture_output=True, text=True, check=True).stdout.splitlines()
    stages = [line.split() for line in lines]
    return [
        {"points": int(count), "stage": stage, "held_bytes": int(held), "most_bytes": int(most)}
        for stage, held, most in stages
    ]


def law(rows: list[dict], column: str) -> tuple[float, float]:
    """Bytes of the process, and of a point, from the greatest of a column at each of two sizes."""
    most = pd.DataFrame(rows).groupby("points")[column].max()
    a_point = (most.iloc[-1] - most.iloc[0]) / (most.index[-1] - most.index[0])
    return float(most.iloc[0] - a_point * most.index[0]), float(a_point)


def silo(cell_size_m: float) -> Scene:
    """A smooth silo of 6 m x 20 m, all of it computed."""
    return Scene(
        silo=Silo(width_m=6.0, height_m=20.0, half="no"), walls=Walls(kind="smooth", friction_angle_deg=22.0),
        grid=Mesh(cell_size_m=cell_size_m), flow=Flow(speed_m_per_s=0.01, displacement_m=0.1),
        machine={"threads": 1},
    )  # fmt: skip


def need(scene: Scene, paces: pd.DataFrame, process: float, a_point: float) -> dict:
    """A row of the table: what a scene takes on one thread, at the pace of the silo nearest in size."""
    sizes = paces[paces.phase == "size"]
    nearest = sizes.iloc[(sizes.points / scene.points - 1.0).abs().argmin()]
    steps = cost_estimate.steps(scene)
    hours = nearest.nanoseconds_per_particle_step * 1e-9 * scene.points * steps / 3600.0
    return {
        "cell_size_m": scene.grid.cell_size_m, "points": scene.points, "steps": steps,
        "core_hours": round(hours, 2), "memory_GiB": round((process + a_point * scene.points) / GIB, 2),
    }  # fmt: skip


def main() -> None:
    """Measure, print, write."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows = [row for points in SIZES for row in memory(points)]
    process, a_point = law(rows, "most_bytes")
    process_stepping, a_point_stepping = law([row for row in rows if row["stage"] == STEPS], "most_bytes")
    print(
        f"at most {process / GIB:.2f} GiB and {a_point:.0f} bytes a point, {a_point_stepping:.0f} of them in the steps"
    )
    runtime.init()
    table = pd.DataFrame([need(silo(cell), pd.read_csv(PACES), process, a_point) for cell in CELLS_M])
    print(table.to_string(index=False))
    laws = pd.DataFrame(
        [("at most", process / GIB, a_point), ("steps", process_stepping / GIB, a_point_stepping)],
        columns=["what", "process_GiB", "bytes_a_point"],
    ).round({"process_GiB": 2, "bytes_a_point": 0})
    for name, found in (("scale", table), ("memory", laws)):
        text = found.to_csv(index=False)
        (FOLDER / f"{name}.csv").write_text(f"# make scale\n{text}", encoding="utf-8")


if __name__ == "__main__":
    main()
