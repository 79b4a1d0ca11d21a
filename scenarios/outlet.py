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

from taichi_silo.cli import command_line
from taichi_silo.cli.scenario import CONTROLLED, OUTLET, SILO, silo_scenario
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.silo import Outlet, Silo

scenario = silo_scenario(
    "Let sand flow through an outlet at a given speed and record forces, wall stresses and shear zones.",
    scene=Scene(silo=Silo(outlet=Outlet(width_m=0.08))),
    paths=(*OUTLET, *SILO, *CONTROLLED),
    name=lambda scene: f"outlet_{scene.silo.outlet.position}_{1e3 * scene.silo.outlet.width_m:g}mm",
)


if __name__ == "__main__":
    command_line.command(scenario)
