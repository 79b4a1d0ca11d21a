"""Mass flow in the model silo: sand between parallel walls, whose whole bottom is slowly lowered.

Source: Krzyzanowski, Tejchman, Solowski and Wojcik (2020), section 6, figures 10 to 13. The paper's four cases
are void ratio 0.60 and 0.90, smooth and very rough walls.

What to expect (dense sand, very rough walls): the bottom force P falls steeply within the first millimetre and
recovers slowly, the wall friction force T peaks and falls, the wall normal force N climbs; dilatant shear zones grow
along the walls and, as parabolas, through the interior.

Cost: 4,000 points and about 570,000 steps at the default speed, some five minutes on two cores.
"""

from taichi_silo.cli import command_line
from taichi_silo.cli.scenario import CONTROLLED, SILO, silo_scenario
from taichi_silo.scene.scene import Scene

scenario = silo_scenario(
    "Lower the bottom of a silo with parallel walls and record forces, wall stresses and shear zones.",
    scene=Scene(),
    paths=(*SILO, *CONTROLLED),
    name=lambda scene: "mass_flow" if scene.silo.section == "plane" else "round_mass_flow",
)


if __name__ == "__main__":
    command_line.command(scenario)
