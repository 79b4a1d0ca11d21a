"""Free outflow: the outlet is opened, and the sand falls out by its own weight until it stops or the silo is empty.

Source: Krzyzanowski et al. (2020), section 7, figure 22: dense sand, very rough walls, an outlet of 80 mm in the
middle, intergranular strain. Here it is on by default (`--law auto`), its memory starting along the strain of filling:
without that sand overshoots its strength at these stresses, and a rough column hangs. `--law gudehus-bauer` is without
it.

What to expect: a funnel above the outlet, a discharge rate of the order of Beverloo's, wall stresses that vary strongly
in time, and, on a floor with friction, sand that stays beside the outlet.

Cost: 4,000 points, about 100,000 steps a second of flow, some 20 seconds each on one core.
"""

from typing import Annotated

from typer import Option

from taichi_silo.cli import command_line, flags
from taichi_silo.cli.scenario_flags import Free
from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Flow
from taichi_silo.scene.silo import Hopper, Outlet, Silo


def gravity_discharge(
    outlet_width: flags.OutletFlag = 0.08,
    outlet_position: flags.PositionFlag = "centre",
    hopper_angle: Annotated[
        float | None, Option(help="half angle of a hopper's walls, from the vertical [deg]; a flat floor if not given")
    ] = None,
    longest: Annotated[float, Option(help="time of flow after which the run ends [s]")] = 4.0,
    share: Annotated[float, Option(help="of the sand that has left when the run ends [-]")] = 1.0,
    width: flags.WidthFlag = 0.2,
    height: flags.HeightFlag = 0.5,
    section: flags.SectionFlag = "plane",
    common: Free = None,
):
    """Open the outlet and record the discharge, forces and wall stresses."""
    shape = {"width_m": width, "height_m": height, "section": section, "half": common.half}
    if hopper_angle is not None and outlet_position != "centre":
        raise BadInput(f"outlet position is {outlet_position}; that of a hopper must be centre")
    if hopper_angle is None:
        silo = Silo(**shape, outlet=Outlet(width_m=outlet_width, position=outlet_position))
    else:
        silo = Silo(**shape, hopper=Hopper(half_angle_deg=hopper_angle, outlet_width_m=outlet_width))
    most = share * silo.area_m2 / silo.outlet_share_m
    common.run(silo, "gravity_discharge", Flow(outflow="gravity", displacement_m=most, longest_s=longest))


if __name__ == "__main__":
    command_line.command(gravity_discharge)
