"""A hopper below a silo: walls that converge towards the outlet, mass flow when they are steep, funnel flow when not.

What to expect: above the transition Janssen's stresses; at the transition a peak of the normal stress on the hopper's
wall once the sand flows (Walker's passive state), and far less stress at the outlet than at rest. A hopper of 15
degrees between smooth walls flows as a whole; one of 45 degrees with rough walls keeps sand on its walls.

Cost: that of mass flow.
"""

from typing import Annotated

from typer import Option

from taichi_silo.cli import command_line, flags
from taichi_silo.cli.scenario_flags import Controlled
from taichi_silo.scene.silo import Hopper, Silo


def hopper(
    half_angle: Annotated[float, Option(help="of the hopper's walls, from the vertical [deg]")] = 20.0,
    outlet_width: flags.OutletFlag = 0.06,
    hopper_friction_angle: Annotated[
        float | None, Option(help="of the hopper's walls [deg]; as the side walls if not given")
    ] = None,
    width: flags.WidthFlag = 0.2,
    height: flags.HeightFlag = 0.5,
    section: flags.SectionFlag = "plane",
    common: Controlled = None,
):
    """Let sand flow out of a hopper at a given speed and record forces, wall stresses and shear zones."""
    silo = Silo(
        width_m=width, height_m=height, section=section, half=common.half,
        hopper=Hopper(
            half_angle_deg=half_angle, outlet_width_m=outlet_width, friction_angle_deg=hopper_friction_angle
        ),
    )  # fmt: skip
    common.run(silo, f"hopper_{half_angle:g}deg")


if __name__ == "__main__":
    command_line.command(hopper)
