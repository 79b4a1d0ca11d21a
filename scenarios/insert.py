"""An insert above the outlet: a roof or a cylinder that parts the flow and carries some of the sand.

The finite element method of the paper's authors failed here. What to expect: the insert takes a load many times the
weight of the sand straight above it when the flow starts, sand below it runs empty or loosens, and the walls beside it
are relieved.

Cost: that of mass flow.
"""

from taichi_silo.cli import command_line
from taichi_silo.cli.scenario import CONTROLLED, silo_scenario
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.silo import Insert, Outlet, Silo

ROOF = Insert(kind="roof", width_m=0.06, bottom_m=0.10)

scenario = silo_scenario(
    "Let sand flow past an insert at a given speed and record forces, the insert's among them.",
    scene=Scene(silo=Silo(outlet=Outlet(width_m=0.08), inserts=(ROOF,))),
    paths=(
        "silo.inserts.0.kind", "silo.inserts.0.width_m", "silo.inserts.0.height_m", "silo.inserts.0.bottom_m",
        "silo.inserts.0.friction_angle_deg", "silo.outlet.width_m", "silo.width_m", "silo.height_m", *CONTROLLED,
    ),
    name=lambda scene: f"insert_{scene.silo.inserts[0].kind}",
)  # fmt: skip


if __name__ == "__main__":
    command_line.command(scenario)
