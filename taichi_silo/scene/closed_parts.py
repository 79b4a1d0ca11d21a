"""What of the floor and of the side walls no outlet opens."""

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taichi_silo.scene.silo import Silo


def closed_parts(silo: "Silo", wall: str) -> list[tuple[float, float]]:
    """Ends of the closed parts of the "floor", along x, or of the "left" or "right" wall, along y [m].

    A wall goes on above and below. A floor that is the outlet has none.
    """
    low, high = silo.floor_m if wall == "floor" else (-math.inf, math.inf)
    openings = [] if silo.column_m is not None else [one for one in silo.openings if one.wall == wall]
    edges = sorted((one.low, one.high) for one in openings)
    ends = zip((low, *(end for _, end in edges)), (*(begin for begin, _ in edges), high), strict=True)
    return [(begin, end) for begin, end in ends if end > begin]
