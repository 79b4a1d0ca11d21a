"""Free outflow: the outlet is opened, and the sand falls out by its own weight until it stops or the silo is empty.

Source: Krzyzanowski et al. (2020), section 7, figure 22: dense sand, very rough walls, an outlet of 80 mm in the
middle, intergranular strain. Here it is on by default (`--law auto`), its memory starting along the strain of filling:
without that sand overshoots its strength at these stresses, and a rough column hangs. `--law gudehus-bauer` is without
it.

What to expect: a funnel above the outlet, a discharge rate of the order of Beverloo's, wall stresses that vary strongly
in time, and, on a floor with friction, sand that stays beside the outlet.

Cost: 4,000 points, about 100,000 steps a second of flow, some 20 seconds each on one core.
"""

from typing import Annotated, Any

from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.cli.scenario import OUTLET, SILO, silo_scenario
from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Flow, Scene
from taichi_silo.scene.silo import Outlet, Silo


def adapt(
    tables: dict[str, Any],
    hopper_angle: Annotated[
        float | None, Option(help="half angle of a hopper's walls, from the vertical [°]; a flat floor if not given")
    ] = None,
    share: Annotated[float, Option(help="share of the sand that has left when the run ends")] = 1.0,
) -> None:
    """Put a hopper in the outlet's place, and let the run end when a share of the sand has left."""
    silo, outlet = tables["silo"], tables["silo"]["outlet"]
    if hopper_angle is not None:
        if outlet["position"] != "centre":
            raise BadInput(f"outlet position is {outlet['position']}; that of a hopper must be centre")
        silo |= {"outlet": None, "hopper": {"half_angle_deg": hopper_angle, "outlet_width_m": outlet["width_m"]}}
    whole = Silo.model_validate(silo)
    tables["flow"]["displacement_m"] = share * whole.area_m2 / whole.outlet_share_m


scenario = silo_scenario(
    "Open the outlet and record the discharge, forces and wall stresses.",
    scene=Scene(silo=Silo(outlet=Outlet(width_m=0.08)), flow=Flow(outflow="gravity", longest_s=4.0)),
    paths=(*OUTLET, "flow.longest_s", *SILO),
    name=lambda scene: "gravity_discharge",
    adapt=adapt,
)


if __name__ == "__main__":
    command_line.command(scenario)
