"""A layer of sand on a very rough wall, sheared from above under a kept pressure, against its one-dimensional solution.

The strip is periodic, so that everything depends on the height alone; the sand is a little looser at the wall, where a
zone of shear forms. `tests/data/layer` holds what a quasi-static solver with Newton's method on the non-local norm
finds (converged to 1e-4), as curves of the same columns.
"""

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import pandas as pd
from typer import Option

from taichi_silo.cli import command_line, flags
from taichi_silo.errors import BadInput
from taichi_silo.mpm import runtime
from taichi_silo.mpm.laws.stress_point import wave_speed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import Gaussian
from taichi_silo.mpm.walls import NoSlip, PlaneWall, RoughFree
from taichi_silo.scene.method_options import MethodOptions
from taichi_silo.scene.scene import Sand
from taichi_silo.simulation.specimen import Specimen

HEIGHT_M = 0.05
LATERAL = 0.42  # stress along x and z over that along y, at first
LOOSER, LOOSER_WITHIN_M = 0.02, 0.005  # e - e0 at the wall, and the length over which it fades as a Gaussian
SHAPE = "cpgimp"  # the zone swells by a third of a cell, which domains that keep their size would leave empty
COLUMNS = 2  # cells along x: patterns that alternate along x shall be possible
SPEED, RAMP_M = 0.002, 2e-5  # of the plate [m/s], reached over so much displacement
ROWS_PER_MM = 50


def layer(
    pressure: float, void_ratio: float, length: float, cells_per_length: float, points_per_cell: int,
    options: MethodOptions | None = None, shape: str = SHAPE, wall: str = "ignored",
    means: str | None = None,
) -> Specimen:  # fmt: skip
    """The strip at rest; Taichi has been started."""
    h, law = length / cells_per_length, Sand(void_ratio=void_ratio).constitutive_law()
    rows = round(HEIGHT_M / h)
    per_axis = math.isqrt(points_per_cell)
    y = Specimen.lattice(COLUMNS * h, rows * h, h, per_axis)[:, 1]
    stress = (-LATERAL * pressure, -pressure, -LATERAL * pressure, 0.0)
    speed = wave_speed(law, stress, void_ratio)

    def walls(grid):
        top = PlaneWall("top", 1, 1, grid.top, RoughFree(), motion=(1.0, 0.0))
        return PlaneWall("bottom", 1, -1, grid.node_along(0.0), NoSlip()), top

    return Specimen(
        law, void_ratio + LOOSER * np.exp(-((y / LOOSER_WITHIN_M) ** 2)), width_m=COLUMNS * h, height_m=rows * h,
        cell_size_m=h, walls=walls, stress=stress, per_axis=per_axis, ambient_pressure=pressure, follows="surface",
        periodic=True, kernel=Gaussian(length), rigid_walls=wall == "rigid", by=means,
        shape=shape, options=options,
        control=NoiseControl.for_column(4.0 * HEIGHT_M / speed),
    )  # fmt: skip


def sheared(piece: Specimen, displacement: float):
    """Rows (displacement [m], shear stress of the plate [Pa], height [m]) while the plate moves so far [m].

    A force is the mean over an interval, so the stress at its end is the mean of that of two intervals.
    """
    width = piece.solver.grid.columns * piece.solver.grid.cell_size
    count = round(1e3 * displacement * ROWS_PER_MM)
    part = displacement / count
    before = None
    for number in range(1, count + 2):
        travel, height = piece.travel, piece.solver.grid.present_height
        speed = SPEED * min(1.0, number * part / RAMP_M)
        stress = piece.drive(2.0 * part / (speed + piece.speed), speed).plate_force_N[0] / width
        yield travel, 0.0 if before is None else 0.5 * (before + stress), height
        before = stress


def run(
    pressure: Annotated[float, Option(help="along y, kept [Pa]", min=100.0)] = 2000.0,
    void_ratio: Annotated[float, Option(help="initial void ratio away from the wall [-]")] = 0.60,
    length: Annotated[float, Option(help="characteristic length of the non-local law [m]", min=1e-4)] = 0.005,
    cells_per_length: Annotated[float, Option(help="cells along the characteristic length", min=0.2)] = 1.0,
    points_per_cell: Annotated[Literal["1", "4", "9"], Option(help="at the start")] = "1",
    displacement: Annotated[float, Option(help="of the plate [m]", min=1e-4)] = 0.004,
    wall: Annotated[Literal["ignored", "rigid"], Option(help="in the non-local mean (averaging.wall)")] = "ignored",
    means: Annotated[Literal["grid", "rows"] | None, Option(help="how they are summed (averaging.means)")] = None,
    shape: flags.ShapeFlag = SHAPE,
    method: flags.MethodFlags = None,
    output: Annotated[Path, Option(help="folder, for curve.csv and points.csv")] = Path("outputs/layer"),
):
    """Shear a layer and write its curve."""
    rows = HEIGHT_M * cells_per_length / length
    if abs(rows - round(rows)) > 1e-6 or round(rows) < 2:
        raise BadInput(
            f"--cells-per-length is {cells_per_length:g}; the height of {HEIGHT_M:g} m must hold a whole "
            f"number of cells, two or more, and holds {rows:.4g}"
        )
    runtime.init()
    piece = layer(
        pressure,
        void_ratio,
        length,
        cells_per_length,
        int(points_per_cell),
        MethodOptions(**method),
        shape,
        wall,
        means,
    )
    curve = pd.DataFrame(sheared(piece, displacement), columns=["displacement_m", "shear_stress_Pa", "height_m"])
    output.mkdir(parents=True, exist_ok=True)
    curve.to_csv(output / "curve.csv", index=False, float_format="%.9g")
    found = piece.particles.arrays()
    table = np.column_stack([found["position"], found["stress"], found["volume"], found["path"]])
    names = ["x_m", "y_m", "xx_Pa", "yy_Pa", "zz_Pa", "xy_Pa", "volume_m2_per_m", "strain_path"]
    pd.DataFrame(table, columns=names).to_csv(output / "points.csv", index=False, float_format="%.9g")


if __name__ == "__main__":
    command_line.command(run)
