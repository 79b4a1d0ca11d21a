"""N and T of inclined walls, from the forces that a run keeps of them: what walls of a hopper carry."""

from typing import Any

import numpy as np

from taichi_silo.scene import polygons
from taichi_silo.scene.silo import Silo

SIGNS = {"left": 1.0, "right": -1.0}  # of the sand's side of a wall


def inclined_walls(silo: Silo, forces) -> dict[str, dict[str, Any]]:
    """N and T [N/m] by the side of a straight inclined wall.

    `forces` are those of `Record.forces`, or rows of `Result.forces`, or a mean of them. N is positive in compression,
    T where the wall pushes the sand up along itself. Of a wall with bends, whose forces have no one direction, there
    are none. Of a round silo they are per metre of girth, as those of its vertical wall.
    """
    found = {}
    share = 0.5 if silo.section == "round" else 1.0  # of the two metres of girth that the rows count
    for name, chain, wall in zip(SIGNS, silo.sides, (0.0, silo.width_m), strict=True):
        inclined = chain[chain[:, 1] <= polygons.foot(chain, wall) + polygons.SAME]
        columns = [f"hopper_{name}_{axis}_N_per_m" for axis in ("horizontal", "vertical")]
        if len(inclined) != 2 or any(column not in forces for column in columns):
            continue
        along = (inclined[1] - inclined[0]) / np.hypot(*(inclined[1] - inclined[0]))
        right, up = (forces[column] for column in columns)
        normal = SIGNS[name] * (right * along[1] - up * along[0])
        found[name] = {"N": share * normal, "T": share * (right * along[0] + up * along[1])}
    return found


def shown_forces(silo: Silo, forces) -> dict[str, Any]:
    """P, T and N [N/m] as they are shown: T and N are means of both walls; where none is vertical, of inclined ones.

    `forces` as in `inclined_walls`.
    """
    found = {name: forces[name] for name in ("P", "T", "N")}
    if none_vertical(silo) and (walls := inclined_walls(silo, forces).values()):
        found |= {name: sum(wall[name] for wall in walls) / len(walls) for name in ("T", "N")}
    return found


def none_vertical(silo: Silo) -> bool:
    """Whether inclined walls lead up to the surface, so that the shown T and N are theirs."""
    return not silo.straight_m and silo.column_m is None


def of_which(silo: Silo) -> str:
    """Of which walls the shown T and N are."""
    return f"T, N: mean of {'the inclined walls' if none_vertical(silo) else 'both walls'}"
