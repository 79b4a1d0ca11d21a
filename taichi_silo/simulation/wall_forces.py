"""The walls' forces on the sand: their order, names and signs, and those of the part of the silo that is not computed.

Arrays of forces have the shape (walls, slots, 2): the walls are left, right and bottom, then the hopper's walls and the
inserts; a slot is a node along the wall, margins included; last come the force to the right and the force upwards. The
normal forces that are reported are positive in compression, shear forces where the wall carries the sand's weight, so
bottom + left shear + right shear = weight for sand at rest.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.simulation.section import Section

LEFT, RIGHT, BOTTOM = 0, 1, 2
MIRRORED = (-1.0, 1.0)  # signs of a force's components in a mirror at constant x


def normal_and_shear(wall: str, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal and shear component of forces or stresses (..., 2) of the left or right wall or the bottom."""
    x, y = force[..., 0], force[..., 1]
    return {"left": (x, y), "right": (-x, y), "bottom": (y, x)}[wall]


@dataclass(frozen=True, eq=False)
class WallForces:
    """Turns the impulses that a solver has booked for its walls into the forces of the walls of the whole silo.

    Attributes
    ----------
    section : the part of the silo that the solver computes.
    paces : vertical velocity of the solver's walls on grid lines (walls, slots), as multiples of the speed at which the
        sand is let out: left, right, those that hold a column, and the bottom or floor, edges of the opening and gate.
    bodies : names of the walls that do not, hopper walls and inserts, in the solver's order.
    owners : LEFT, RIGHT or BOTTOM for each of the solver's walls on grid lines, such as a gate in the left wall; if
        not told left, right, and all others the bottom.
    sideways : horizontal velocities of these (walls,), as `paces`; if not told none.

    """

    section: Section
    paces: np.ndarray
    bodies: tuple[str, ...]
    owners: tuple[int, ...] = ()
    sideways: tuple[float, ...] = ()

    @property
    def on_grid(self) -> int:
        """How many of the solver's walls lie on grid lines."""
        return len(self.paces)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the walls in the order of the arrays."""
        return ("left", "right", "bottom", *self.bodies)

    def read(self, impulse: np.ndarray, duration: float) -> tuple[dict[str, Any], np.ndarray]:
        """Columns of a record [N/m], and nodal forces, from impulses (solver's walls, slots, 2) [N s/m] of so long [s].

        Nodal forces are those over the width that a node has: cell size times stress [N/m].
        """
        owners = np.array(self.owners or [LEFT, RIGHT] + [BOTTOM] * (self.on_grid - BOTTOM))
        sides = [impulse[: self.on_grid][owners == wall].sum(axis=0) for wall in (LEFT, RIGHT, BOTTOM)]
        own = np.concatenate([sides, impulse[self.on_grid :]]) / duration
        forces = self._of_both_sides(own)
        total = dict(zip(self.names, forces.sum(axis=1), strict=True))
        columns = {"bottom_force_N_per_m": normal_and_shear("bottom", total["bottom"])[0]}
        for wall in ("left", "right"):
            normal, shear = normal_and_shear(wall, total[wall])
            columns |= {f"{wall}_normal_N_per_m": normal, f"{wall}_shear_N_per_m": shear}
        bodies = {name: total[name].tolist() for name in self.bodies}
        return columns | {"bodies_N_per_m": bodies}, self._profile(own) if self.section.round else forces

    def push(self, impulse: np.ndarray, shares: np.ndarray | None = None) -> float:
        """Impulse of the walls that move, each times its pace, from impulses as in `read` [N s/m].

        `shares` (walls,) of their paces are those of walls that do not move all the time.
        """
        pace, on_grid = self.paces if shares is None else self.paces * shares[:, None], impulse[: self.on_grid]
        found = float((on_grid[:, :, 1] * pace).sum())
        if self.sideways:
            across = np.array(self.sideways) * (1.0 if shares is None else shares)
            found += float(on_grid[:, :, 0].sum(axis=1) @ across)
        return self.section.factor * found

    def _of_both_sides(self, own: np.ndarray) -> np.ndarray:
        """Forces of the walls of the whole silo, from those of the computed part."""
        if self.section.round:
            whole = own * self.section.factor
            whole[RIGHT] *= 0.5
            whole[LEFT] = whole[RIGHT] * MIRRORED
            whole[BOTTOM:, :, 0] = 0.0  # what points away from the axis everywhere adds up to nothing
            return whole
        return mirrored(own, self.section.columns) if self.section.half else own

    def _profile(self, own: np.ndarray) -> np.ndarray:
        """Nodal forces of a round silo over the width that a node has, in the section from wall to wall."""
        width, columns = self.section.width, self.section.columns
        h = 2.0 * width / (columns - 1 - 2 * MARGIN)
        found = own.copy()
        found[RIGHT] /= width
        found[LEFT] = found[RIGHT] * MIRRORED
        radius = np.maximum((np.arange(own.shape[1]) - MARGIN) * h, 0.25 * h)
        found[BOTTOM] /= radius[:, None]
        cells = round(width / h)
        right = found[BOTTOM, MARGIN : MARGIN + cells + 1 + MARGIN]
        whole = np.zeros((len(found), max(own.shape[1], columns), 2))
        whole[:, : own.shape[1]] = found
        whole[BOTTOM] = 0.0
        whole[BOTTOM, MARGIN + cells : MARGIN + cells + len(right)] += right
        whole[BOTTOM, MARGIN + cells - len(right) + 1 : MARGIN + cells + 1] += right[::-1] * MIRRORED
        return whole


def mirrored(half: np.ndarray, columns: int) -> np.ndarray:
    """Nodal forces of a whole plane silo from those of its left half, whose second wall is the axis.

    `columns` is the number of nodes across the whole silo, margins included. The node of the bottom on the axis has its
    share from both halves.
    """
    slots = half.shape[1]
    whole = np.zeros((3, max(slots, columns), 2))
    whole[LEFT, :slots] = half[LEFT]
    whole[RIGHT, :slots] = half[LEFT] * MIRRORED
    along = half[BOTTOM, : min(slots, columns)]
    whole[BOTTOM, : len(along)] = along
    whole[BOTTOM, columns - len(along) : columns] += along[::-1] * MIRRORED
    return whole
