"""The C++ program that speed is measured against: the same method with explicit vectorisation, 4 points a cell.

`mpm2d.cpp` is looked for in $TAICHI_SILO_YARDSTICK and in ../shared/yardstick; without it, or without a C++ compiler,
figures are absolute. Those move by a third from hour to hour on a shared machine: quote the ratio, measured in turns.

With one point a cell a step has as many nodes as points, with four a quarter of them. So that both can be compared with
the same work the program is compiled once more, with a lattice of one point a cell, if its source says what is changed.
"""

import os
import re
import subprocess
import tempfile
from pathlib import Path

FLAGS = ("-O3", "-march=native", "-mprefer-vector-width=512", "-ffast-math", "-fopenmp", "-std=c++17")
CELLS = {4: (32, 128, 256), 1: (64, 128, 256)}  # per side, the sizes offered with so many points a cell
ONE_A_CELL = {  # what its source says, and what it must say for a lattice of one point a cell
    "np=4*W*W": "np=W*W",
    "(2*W)": "W",
    "rho/W/W/4": "rho/W/W",
    "1.0/W/W/4": "1.0/W/W",
    "Ws[]={32,128,256}, st[]={1280,128,64}; \n": "Ws[]={64,128,256}, st[]={1280,320,64};\n",
}


class Yardstick:
    """The program, compiled for each number of points a cell."""

    @classmethod
    def find(cls) -> "Yardstick | None":
        """Compile it if it is there; None where it cannot be had."""
        here = Path(os.environ.get("TAICHI_SILO_YARDSTICK", Path(__file__).parents[2] / "shared" / "yardstick"))
        try:
            source = (here / "mpm2d.cpp").read_text()
            programs = {4: compiled(source)}
            if all(said in source for said in ONE_A_CELL):
                programs[1] = compiled(one_a_cell(source))
        except (OSError, subprocess.CalledProcessError):
            return None
        return cls(programs)

    def __init__(self, programs: dict[int, Path]):
        self.programs = programs

    def rate(self, threads: int, points: int, points_per_cell: int = 4) -> float:
        """Particle-steps per second of the hypoplastic law in f64 at the nearest size it offers."""
        cells = min(CELLS[points_per_cell], key=lambda side: abs(points_per_cell * side * side - points))
        text = subprocess.run(
            [str(self.programs[points_per_cell]), "f64", str(threads), str(cells)],
            capture_output=True, text=True, check=True, env=os.environ | {"OMP_PROC_BIND": "true"},
        ).stdout  # fmt: skip
        return 1e6 * float(re.search(r"GB\s.*?([\d.]+) Mp/s", text).group(1))


def one_a_cell(source: str) -> str:
    """The program with a lattice of one point a cell."""
    for said, wanted in ONE_A_CELL.items():
        source = source.replace(said, wanted)
    return source


def compiled(source: str) -> Path:
    """The program of a source."""
    folder = Path(tempfile.mkdtemp())
    (folder / "mpm2d.cpp").write_text(source)
    subprocess.run(["g++", *FLAGS, "mpm2d.cpp", "-o", "mpm2d"], cwd=folder, check=True, capture_output=True)
    return folder / "mpm2d"
