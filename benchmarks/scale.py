"""What a silo of any size takes: memory measured here, seconds from the paces that `make bench` has left.

    memory = process + bytes a point * points
    seconds = nanoseconds a point and step * points * steps / threads

`make scale` prints both for a silo of 6 m x 20 m, and writes outputs/bench/scale.csv and memory.csv.
"""

import argparse
import subprocess
import sys
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
STEPPING = ("silo ready", "steps", "snapshot", "checkpoint")
STAGES = (*STEPPING, "filled", "guarded")  # the last two: what summary and guard keep, and look at
PROGRAM = """
import tempfile
from pathlib import Path
from types import SimpleNamespace
from benchmarks.bench import loaded
from taichi_silo.runs import snapshot
from taichi_silo.runs.observers import guard, summary
from taichi_silo.utils import checked_npz
def said(name):
    for line in open("/proc/self/status"):
        if line.startswith(name):
            return 1024 * int(line.split()[1])
def show():
    print(said("VmRSS"), said("VmHWM"))
    open("/proc/self/clear_refs", "w").write("5")  # the greatest from now on
s = loaded({points}, 1, 1)
print(s.scene.points)
show()
s.solver.advance(3, 0.5 * s.solver.point_sums().stable_step, gravity=(9.81, 9.81))
s.solver.filter.turn()
show()
folder = Path(tempfile.mkdtemp())
snapshot.write_pieces(folder / "one.vtu", s.names_of_points, s.pieces)
show()
checked_npz.write(folder / "one.npz", {{"simulation": s.state()}})
show()
keeping = guard.Guard(), summary.Summary(folder / "summary.json", None)
for one in keeping:
    one.begin(s)
    one.filled()
show()
points = s.points(*guard.FIELDS)
for one in keeping[0].of_points:
    one.look(SimpleNamespace(time_s=1.0, stage="flow"), points)
del points
show()
"""


def memory(points: int) -> list[dict]:
    """What a process with a silo of so many points holds, and has held at most in each stage [bytes]; on Linux."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(points=points)], capture_output=True, text=True, check=True
    )
    count, *numbers = map(int, done.stdout.split())
    return [
        {"points": count, "stage": stage, "held_bytes": held, "most_bytes": most}
        for stage, held, most in zip(STAGES, numbers[::2], numbers[1::2], strict=True)
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
    for points in SIZES:  # compiles, which takes memory of its own
        memory(points)
    rows = [row for points in SIZES for row in memory(points)]
    process, a_point = law(rows, "most_bytes")
    process_stepping, a_point_stepping = law([row for row in rows if row["stage"] in STEPPING], "most_bytes")
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
