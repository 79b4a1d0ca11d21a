"""Failure mode 10: how few digits a step can do with, at bottom speeds that span three decades.

Run as a program, it does one precision: the environment variable TAICHI_SILO_PRECISION says which.
"""

import json
import os
import subprocess
import sys

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "10 precision"
SPEEDS = (0.1, 0.01, 0.001, 0.0001)  # of the bottom [m/s]
DISPLACEMENT_M = 2e-4
PRECISIONS = ("f64", "mixed", "f32")


def flow(speed: float) -> dict[str, float]:
    """The model silo with very rough walls on 20 mm cells, filled and lowered by 0.2 mm at a speed.

    Returns
    -------
    normal: N in flow [N/m]; void_ratio: change of its mean in flow; travel: how far the points sank, over the bottom.

    """
    scene = Scene(
        silo=Silo(width_m=0.2, height_m=0.5), walls=Walls(kind="very-rough"), grid=Mesh(cell_size_m=0.02),
        averaging=Averaging(characteristic_length_m=0.0),
        flow=Flow(speed_m_per_s=speed, displacement_m=DISPLACEMENT_M), machine=Machine(threads=1),
    )  # fmt: skip
    simulation = Simulation(scene)
    for _record in simulation.fill():
        pass
    before = simulation.points()
    rows = [(record.normal_N_per_m, record.interval_s) for record in simulation.flow()]
    after = simulation.points()
    normal, weight = np.array(rows[len(rows) // 2 :]).T
    gone = (before["position"] - after["position"])[:, 1]
    return {
        "normal": float(normal @ weight / weight.sum()),
        "void_ratio": float((after["void_ratio"] - before["void_ratio"]).mean()),
        "travel": float(gone.mean() / DISPLACEMENT_M),
    }  # fmt: skip


def measured(precision: str, speeds=SPEEDS) -> list[dict[str, float]]:
    """`flow` at each speed, in a process of that precision."""
    command = [sys.executable, "-m", "validation.stability.precision", *map(str, speeds)]
    done = subprocess.run(
        command, env=os.environ | {"TAICHI_SILO_PRECISION": precision}, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


def measure(full: bool = True) -> list[Measurement]:
    """Each precision at each speed: N against f64, drift of the void ratio, travel of the points."""
    speeds = SPEEDS if full else (0.01,)
    found = []
    rows = {name: measured(name, speeds) for name in PRECISIONS}
    for number, speed in enumerate(speeds):
        exact = rows["f64"][number]
        for measure, words, bound, error in (
            ("normal", "N in flow", 0.01, lambda row, exact: abs(row["normal"] / exact["normal"] - 1.0)),
            ("void_ratio", "void ratio", 1e-4, lambda row, exact: abs(row["void_ratio"] - exact["void_ratio"])),
            ("travel", "travel of the sand", 0.01, lambda row, exact: abs(row["travel"] - exact["travel"])),
        ):
            values = {name: error(rows[name][number], exact) for name in PRECISIONS}
            words_at = f"difference from f64: {words}, bottom at {1e3 * speed:g} mm/s"
            unit = "of its own" if measure != "void_ratio" else "-"
            found += measurements(words_at, unit, "<=", bound, values)
    return found


if __name__ == "__main__":
    runtime.init()
    print(json.dumps([flow(float(word)) for word in sys.argv[1:]]))
