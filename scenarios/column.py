"""Collapse of a granular column: a smooth wall that holds the sand is taken away, and the sand spreads over the floor.

Source: Lube, Huppert, Sparks and Freundt (Phys. Rev. E 72 (2005) 041301), dry grains in a channel: with a = H0 / L0 the
run-out (L - L0) / L0 is 1.2 a for a < 1.8 and 1.9 a^(2/3) for a > 2.8, the final height H / L0 is a below 1.15 and
a^0.4 above, whatever the grains and the floor.

What to expect: low columns slide off at the free side and keep a flat top; high ones fall, push a front along, and
leave a cone that is flatter than the angle of repose. The run ends at rest.

Cost: 1,600 points and some 100,000 steps, three minutes on one core.
"""

import math
from typing import Annotated, Any

from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.cli.scenario import silo_scenario
from taichi_silo.errors import BadInput
from taichi_silo.scene.flow import Flow
from taichi_silo.scene.mesh import Mesh
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.scene import Scene, Walls
from taichi_silo.scene.silo import Silo

CELL_M, FREE = 0.005, 1.6  # default cells; room for more than the run-out that is expected


def expected_run_out(aspect: float) -> float:
    """(L - L0) / L0 of a channel, after Lube et al. (2005); between both regimes the greater of the two."""
    return max(1.2 * aspect, 1.9 * aspect ** (2.0 / 3.0)) if aspect > 1.8 else 1.2 * aspect


def adapt(
    tables: dict[str, Any],
    column_width: Annotated[float, Option(help="breadth of the column [m]")] = 0.1,
    aspect_ratio: Annotated[
        float, Option(help="height over length L0: the breadth, or half of it where both sides are free")
    ] = 1.0,
    sides: Annotated[
        str, Option(help="right | both: on which side the sand is free; round columns are on all")
    ] = "right",
) -> None:
    """Put the column into a channel with room enough."""
    if sides not in ("right", "both"):
        raise BadInput(f"sides is {sides}; it must be right or both")
    if not 0.05 <= aspect_ratio <= 50.0:
        raise BadInput(f"aspect ratio is {aspect_ratio:g}; it must be between 0.05 and 50")
    if not 0.0 < column_width <= 100.0:
        raise BadInput(f"column width is {column_width:g} m; it must be above 0 and at most 100")
    both = sides == "both" or tables["silo"]["section"] == "round"
    cell = tables["grid"].setdefault("cell_size_m", CELL_M * column_width / 0.1)
    whole = max(2, round(column_width / (2.0 * cell))) * 2 if both else max(2, round(column_width / cell))
    length = 0.5 * column_width if both else column_width
    high = max(2, round(aspect_ratio * length / cell))
    free = math.ceil(FREE * (1.0 + expected_run_out(aspect_ratio)) * length / cell)
    left = free if both else 0
    edges = tuple(round(cells * cell, 12) for cells in (left, left + whole, left + whole + free, high))
    tables["silo"] |= {"column_m": edges[:2], "width_m": edges[2], "height_m": edges[3]}
    tables["flow"].pop("displacement_m", None)
    tables["flow"].pop("longest_s", None)


scenario = silo_scenario(
    "Take the wall of a column of sand away and record how it spreads, until it rests.",
    scene=Scene(
        silo=Silo(width_m=0.4, height_m=0.1, column_m=(0.0, 0.1)),
        sand=Sand(void_ratio=0.80),
        walls=Walls(kind="smooth", friction_angle_deg=0.0, bottom_friction_angle_deg=30.0),
        grid=Mesh(cell_size_m=CELL_M, points_per_cell=4),
        flow=Flow(outflow="collapse"),
    ),
    paths=("silo.section",),
    name=lambda scene: "column",
    adapt=adapt,
)


if __name__ == "__main__":
    command_line.command(scenario)
