"""An insert above the outlet: a roof or a cylinder that parts the flow and carries some of the sand.

The finite element method of the paper's authors failed here. What to expect: the insert takes a load many times the
weight of the sand straight above it when the flow starts, sand below it runs empty or loosens, and the walls beside it
are relieved.

Cost: that of mass flow.
"""

from typing import Annotated

from typer import Option

from taichi_silo.cli import command_line, flags
from taichi_silo.cli.scenario_flags import Controlled
from taichi_silo.scene.silo import Insert, Outlet, Silo


def insert(
    kind: Annotated[str, Option(help="roof | cylinder")] = "roof",
    insert_width: Annotated[float, Option(help="of the roof's base, or diameter of the cylinder [m]")] = 0.06,
    insert_height: Annotated[float | None, Option(help="of a roof [m]; as high as wide if not given")] = None,
    insert_bottom: Annotated[float, Option(help="lowest place of the insert above the floor [m]")] = 0.10,
    insert_friction_angle: Annotated[
        float | None, Option(help="of the insert [deg]; as the side walls if not given")
    ] = None,
    outlet_width: flags.OutletFlag = 0.08,
    width: flags.WidthFlag = 0.2,
    height: flags.HeightFlag = 0.5,
    common: Controlled = None,
):
    """Let sand flow past an insert at a given speed and record forces, the insert's among them."""
    body = Insert(
        kind=kind, width_m=insert_width, height_m=insert_height, bottom_m=insert_bottom,
        friction_angle_deg=insert_friction_angle,
    )  # fmt: skip
    silo = Silo(width_m=width, height_m=height, half=common.half, outlet=Outlet(width_m=outlet_width), inserts=(body,))
    common.run(silo, f"insert_{kind}")


if __name__ == "__main__":
    command_line.command(insert)
