"""Controlled flow through an outlet in the floor, symmetric or beside a wall.

Source: Krzyzanowski, Tejchman, Solowski and Wojcik (2020), section 7, figures 14 to 21. The paper's twelve cases are
an outlet of 80 mm in the middle, and of 150 and of 50 mm beside the right wall, each with void ratio 0.60 and 0.90 and
with smooth and very rough walls. The sand in the outlet stands on a gate that sinks at a constant speed; what has
passed the floor is taken out and kept in a ledger (`discharged_kg_per_m`).

What to expect: funnel flow from dense sand, whose shear zones rise steeply from the edges of the outlet, branch where
they meet a wall beside the outlet, and dilate; wall stresses that grow above the height where the moving sand meets the
wall and fall below it.

Cost: that of mass flow (4,000 points and about 570,000 steps, some two minutes on two cores).
"""

from typing import Annotated

from typer import Option

from taichi_silo import cli
from taichi_silo.scenario import Controlled
from taichi_silo.vessel import Outlet, Silo


def outlet(
    outlet_width: Annotated[float, Option(help="of the opening of the floor [m]; its edges lie on the grid")] = 0.08,
    outlet_position: Annotated[str, Option(help="centre | left | right: in the middle, or beside a wall")] = "centre",
    width: Annotated[float, Option(help="of the silo, or its diameter [m]")] = 0.2,
    height: Annotated[float, Option(help="of the fill [m]")] = 0.5,
    section: Annotated[str, Option(help="plane | round: between parallel walls, or in a cylinder")] = "plane",
    common: Controlled = None,
):
    """Let sand flow through an outlet at a given speed and record forces, wall stresses and shear zones."""
    silo = Silo(
        width_m=width, height_m=height, section=section, half=common.half,
        outlet=Outlet(width_m=outlet_width, position=outlet_position),
    )  # fmt: skip
    common.run(silo, f"outlet_{outlet_position}_{1e3 * outlet_width:g}mm")


if __name__ == "__main__":
    cli.command(outlet)
