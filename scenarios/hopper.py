"""A hopper below a silo: walls that converge towards the outlet, mass flow when they are steep, funnel flow when not.

What to expect: above the transition Janssen's stresses; at the transition a peak of the normal stress on the hopper's
wall once the sand flows (Walker's passive state), and far less stress at the outlet than at rest. A hopper of 15
degrees between smooth walls flows as a whole; one of 45 degrees with rough walls keeps sand on its walls.

Cost: that of mass flow.
"""

from taichi_silo.cli import command_line
from taichi_silo.cli.scenario import CONTROLLED, SILO, silo_scenario
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.silo import Hopper, Silo

scenario = silo_scenario(
    "Let sand flow out of a hopper at a given speed and record forces, wall stresses and shear zones.",
    scene=Scene(silo=Silo(hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.06))),
    paths=(
        "silo.hopper.half_angle_deg", "silo.hopper.outlet_width_m", "silo.hopper.friction_angle_deg",
        *SILO, *CONTROLLED,
    ),
    name=lambda scene: f"hopper_{scene.silo.hopper.half_angle_deg:g}deg",
)  # fmt: skip


if __name__ == "__main__":
    command_line.command(scenario)
