"""N and T of inclined walls, from the forces that a run keeps of them: what walls of a hopper carry."""

from typing import Any

import numpy as np

from taichi_silo.runs.result import Result
from taichi_silo.scene import polygons

SIGNS = {"left": 1.0, "right": -1.0}  # of the sand's side of a wall


def inclined_walls(run: Result, rows) -> dict[str, dict[str, Any]]:
    """N and T [N/m] of rows of `Result.forces`, or of a mean of them, by the side of a straight inclined wall.

    N is positive in compression, T where the wall pushes the sand up along itself. Of a wall with bends, whose forces
    have no one direction, there are none. Of a round silo they are per metre of girth, as those of its vertical wall.
    """
    found, silo = {}, run.scene.silo
    share = 0.5 if silo.section == "round" else 1.0  # of the two metres of girth that the rows count
    for name, chain, wall in zip(SIGNS, silo.sides, (0.0, silo.width_m), strict=True):
        inclined = chain[chain[:, 1] <= polygons.foot(chain, wall) + polygons.SAME]
        columns = [f"hopper_{name}_{axis}_N_per_m" for axis in ("horizontal", "vertical")]
        if len(inclined) != 2 or not set(columns) <= set(rows.index if rows.ndim == 1 else rows.columns):
            continue
        along = (inclined[1] - inclined[0]) / np.hypot(*(inclined[1] - inclined[0]))
        right, up = (rows[column] for column in columns)
        normal = SIGNS[name] * (right * along[1] - up * along[0])
        found[name] = {"N": share * normal, "T": share * (right * along[0] + up * along[1])}
    return found
