"""Whether the lanes of lanes.py can be trusted on this machine: tried in a process of its own, and remembered.

They rest on a switch inside Taichi that ends the whole process where it meets an operation it does not know, and no
other processor and version than those of the tests can be promised. So before the first use a small silo is stepped
both ways in a child process; whatever happens there, this process goes on, with the plain loop if need be.
"""

import functools
import hashlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import taichi as ti

STEPS = 50
TOLERANCE = 1e-10  # of each field
PATIENCE_S = 300.0
PACKAGE = Path(__file__).parent


def place() -> Path:
    """File of the verdicts."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "taichi_silo" / "lanes.json"


def circumstances() -> str:
    """What the verdict depends on: processor, versions, and the formulas themselves."""
    sources = hashlib.sha256()
    for file in sorted(PACKAGE.rglob("*.py")):
        sources.update(file.read_bytes())
    model = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model += " ".join(line for line in lines if line.startswith(("model name", "CPU part")))[:200]
    return f"{model} | python {platform.python_version()} | taichi {ti.__version__} | {sources.hexdigest()}"


@functools.cache
def failure() -> str:
    """Why lanes are not to be trusted here; empty if they are. Takes some seconds, once on a machine."""
    key, file = circumstances(), place()
    try:
        verdicts = json.loads(file.read_text())
        if verdicts["circumstances"] == key:
            return verdicts["failure"]
    except (OSError, ValueError, KeyError, TypeError):
        pass
    verdict = _try()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary = file.with_suffix(f".{os.getpid()}")
        temporary.write_text(json.dumps({"circumstances": key, "failure": verdict}))
        temporary.replace(file)
    except OSError:
        pass  # it will be tried again
    return verdict


def _try() -> str:
    try:
        done = subprocess.run(
            [sys.executable, "-m", "taichi_silo.proof"], capture_output=True, text=True, timeout=PATIENCE_S,
            cwd=PACKAGE.parent,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"the trial did not end ({type(error).__name__})"
    if done.returncode < 0 or done.returncode > 1:
        return f"the trial ended with code {done.returncode}"
    return "" if done.returncode == 0 else (done.stdout.strip().splitlines() or ["the trial failed"])[-1]


def compare() -> str:
    """Step a small silo on lanes and plainly; empty if both agree."""
    from taichi_silo import runtime
    from taichi_silo.scene import Machine, Mesh, Scene, Silo, Walls
    from taichi_silo.simulation import Simulation

    ends = []
    for lanes in (False, True):
        runtime.init()
        scene = Scene(
            silo=Silo(width_m=0.1, height_m=0.2), walls=Walls(kind="smooth"), grid=Mesh(cell_size_m=0.02),
            machine=Machine(threads=1),
        )  # fmt: skip
        simulation = Simulation(scene, lanes=lanes)
        simulation.solver.advance(STEPS, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
        ends.append(simulation.particles.arrays())
    for name, field in ends[0].items():
        apart = np.abs(field - ends[1][name]).max()
        if not apart <= TOLERANCE * np.abs(field).max():
            return f"lanes and plain loop differ by {apart:g} in {name}"
    return ""


if __name__ == "__main__":
    found = compare()
    print(found)
    sys.exit(1 if found else 0)
