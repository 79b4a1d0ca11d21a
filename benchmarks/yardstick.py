"""The C++ program that speed is measured against: the same method with explicit vectorisation, 4 points a cell.

`mpm2d.cpp` is looked for in $TAICHI_SILO_YARDSTICK and in ../shared/yardstick; without it, or without a C++ compiler,
figures are absolute. Those move by a third from hour to hour on a shared machine: quote the ratio, measured in turns.
"""

import os
import re
import subprocess
import tempfile
from pathlib import Path

FLAGS = ("-O3", "-march=native", "-mprefer-vector-width=512", "-ffast-math", "-fopenmp", "-std=c++17")
CELLS = (32, 128, 256)  # per side, the sizes that it offers; its points are 4 a cell


class Yardstick:
    """The program, compiled once."""

    @classmethod
    def find(cls) -> "Yardstick | None":
        """Compile it if it is there; None where it cannot be had."""
        here = Path(os.environ.get("TAICHI_SILO_YARDSTICK", Path(__file__).parents[2] / "shared" / "yardstick"))
        source = here / "mpm2d.cpp"
        if not source.exists():
            return None
        program = Path(tempfile.mkdtemp()) / "mpm2d"
        try:
            subprocess.run(["g++", *FLAGS, str(source), "-o", str(program)], check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            return None
        return cls(program)

    def __init__(self, program: Path):
        self.program = program

    def rate(self, threads: int, points: int) -> float:
        """Particle-steps per second of the hypoplastic law in f64 at the nearest size it offers."""
        cells = min(CELLS, key=lambda side: abs(4 * side * side - points))
        text = subprocess.run(
            [str(self.program), "f64", str(threads), str(cells)],
            capture_output=True, text=True, check=True, env=os.environ | {"OMP_PROC_BIND": "true"},
        ).stdout  # fmt: skip
        return 1e6 * float(re.search(r"GB\s.*?([\d.]+) Mp/s", text).group(1))
