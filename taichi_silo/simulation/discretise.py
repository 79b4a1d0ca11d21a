"""From a scene to what is computed: points, grid and walls in the frame of the grid.

Of a plane silo everything is computed, or its left half; of a round one the section from its axis (x = 0 of the grid)
to its wall. `Section` knows which, and turns what was computed into what stands in the laboratory.
"""

import math
from dataclasses import dataclass

import numpy as np

from taichi_silo.mpm.geometry import Axisymmetric, PlaneStrain
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.walls import Coulomb, Frictionless, Gate, NoSlip, OpenFloor, PlaneWall, Surface
from taichi_silo.scene import polygons as polygons
from taichi_silo.scene.symmetry import half_model, whole_points, whole_profile

LEFT, RIGHT, BOTTOM = 0, 1, 2
HEADROOM = 0.1  # of the fill height, free above it; more where sand hangs on a very rough wall while the grid sinks


@dataclass(frozen=True)
class Section:
    """Which part of a silo is computed, [0, width] of the grid."""

    width: float  # [m]
    shift: float  # x of the laboratory less x of the grid [m]
    half: bool  # of a plane silo
    round: bool
    columns: int  # of nodes across the silo, margins included

    @classmethod
    def of(cls, scene) -> "Section":
        """For a scene."""
        silo, round_ = scene.silo, scene.silo.section == "round"
        half = half_model(scene)[0]
        width = 0.5 * silo.width_m if half or round_ else silo.width_m
        columns = round(silo.width_m / scene.grid.cell_size_m) + 1 + 2 * MARGIN
        return cls(width, width if round_ else 0.0, half, round_, columns)

    @property
    def geometry(self):
        """Plane or round."""
        return Axisymmetric() if self.round else PlaneStrain()

    @property
    def whole(self) -> float:
        """What is reported over what is computed, for sums over the sand.

        Of a round silo that is twice what belongs to a metre of the wall's girth, so that left and right wall, which
        are a metre of girth each, and the bottom carry the weight of the sand, as in a plane silo.
        """
        if self.round:
            return 2.0 / self.width
        return 2.0 if self.half else 1.0

    def forces(self, reaction: np.ndarray) -> np.ndarray:
        """Forces (walls, slots, 2) on the sand: of the left and right wall and the bottom, then of further bodies."""
        if self.round:
            found = reaction * self.whole
            found[RIGHT] *= 0.5
            found[LEFT] = found[RIGHT] * (-1.0, 1.0)
            found[BOTTOM:, :, 0] = 0.0  # what points away from the axis everywhere adds up to nothing
            return found
        return whole_profile(reaction, self.columns) if self.half else reaction

    def profile(self, reaction: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Nodal forces (walls, slots, 2) over the width that a node has, cells times stress [N/m].

        `forces` are those of the same reaction: of a plane silo they are the profile.
        """
        if not self.round:
            return forces
        h = 2.0 * self.width / (self.columns - 1 - 2 * MARGIN)
        found = reaction.copy()
        found[RIGHT] /= self.width
        found[LEFT] = found[RIGHT] * (-1.0, 1.0)
        radius = np.maximum((np.arange(reaction.shape[1]) - MARGIN) * h, 0.25 * h)
        found[BOTTOM] /= radius[:, None]
        # the section from wall to wall: right half, and its image
        cells = round(self.width / h)
        right = found[BOTTOM, MARGIN : MARGIN + cells + 1 + MARGIN]
        whole = np.zeros((len(found), max(reaction.shape[1], self.columns), 2))
        whole[:, : reaction.shape[1]] = found
        whole[BOTTOM] = 0.0
        whole[BOTTOM, MARGIN + cells : MARGIN + cells + len(right)] += right
        whole[BOTTOM, MARGIN + cells - len(right) + 1 : MARGIN + cells + 1] += right[::-1] * (-1.0, 1.0)
        return whole

    def points(self, own: dict[str, np.ndarray], silo_width_m: float) -> dict[str, np.ndarray]:
        """Fields of the points of the whole silo, in the laboratory."""
        if self.round:
            radius = own["position"][:, 0].copy()
            own = own | {name: own[name] / radius for name in ("mass", "volume")}  # per metre of their own girth
            right = own | {"position": own["position"] + (self.shift, 0.0)}
            return whole_points(right, silo_width_m)
        return whole_points(own, silo_width_m) if self.half else own


def headroom(scene) -> float:
    """Height of the grid above the fill [m]."""
    h, room = scene.grid.cell_size_m, HEADROOM * scene.silo.height_m
    if scene.silo.floor_is_outlet:
        room = max(room, scene.flow.displacement_m)
    if scene.filling.kind == "rain":
        room = max(room, scene.filling.drop_m)
    return room + 2.0 * h


def rows_of_cells(scene) -> int:
    """How many the grid has, from the floor to its top."""
    return math.ceil((scene.silo.height_m + headroom(scene)) / scene.grid.cell_size_m - 1e-9)


def grid_of(scene, section: Section, copies: int) -> Grid:
    """The grid: it sinks with the bottom where all of that sinks, else it stands still."""
    h = scene.grid.cell_size_m
    follows = "bottom" if scene.silo.floor_is_outlet else "nothing"
    return Grid(section.width, rows_of_cells(scene) * h, h, copies=copies, follows=follows)


def state_of_fill(scene, section: Section, law, density: float) -> dict[str, np.ndarray]:
    """Fields of the points of the full silo, row after row from the floor, without stress."""
    d = scene.spacing_m
    x, y, volume = scene.silo.lattice(d)
    computed = (x > section.shift) & (x < section.shift + section.width)
    x, y, volume = x[computed] - section.shift, y[computed], volume[computed]
    count, volume = len(x), volume * section.geometry.depth(x)
    state = {
        "position": np.stack([x, y], axis=1),
        "velocity": np.zeros((count, 2)),
        "stress": np.tile([-law.rest_stress] * 3 + [0.0], (count, 1)),
        "mass": density * volume,
        "volume": volume,
        "path": np.zeros(count),
        "domain": np.tile([d, 0.0, 0.0, d], (count, 1)),
    }
    if law.REMEMBERS:  # the last strain is that of filling: vertical compression
        state["intergranular"] = np.tile([0.0, -law.radius, 0.0, 0.0], (count, 1))
    return state


def side_contact(scene, friction_angle_deg: float | None = None):
    """Contact of the side walls, or of another wall with an angle of its own."""
    if friction_angle_deg is not None:
        return Coulomb(friction_angle_deg)
    return NoSlip() if scene.walls.kind == "very-rough" else Coulomb(scene.walls.friction_angle_deg)


def walls_of(scene, section: Section, grid: Grid) -> tuple:
    """Left, right, bottom; or left, right, floor (empty above an open hopper) and gate."""
    silo, h, side = scene.silo, scene.grid.cell_size_m, side_contact(scene)
    low = tuple(MARGIN + math.ceil(foot / h - 1e-9) if foot else 0 for foot in silo.feet_m)
    left, right = grid.node_along(0.0), grid.node_along(section.width)
    axis = Frictionless()
    sides = (
        PlaneWall("axis", 0, -1, left, axis) if section.round else PlaneWall("left", 0, -1, left, side, lowest=low[0]),
        PlaneWall("axis", 0, 1, right, axis) if section.half else PlaneWall("right", 0, 1, right, side, lowest=low[1]),
    )
    plate = Coulomb(scene.walls.bottom_friction_angle_deg)
    floor = grid.node_along(0.0)
    if silo.floor_is_outlet:
        return (*sides, PlaneWall("bottom", 1, -1, floor, plate, motion=(0.0, 1.0)))
    first, last = _edges(scene, section, grid)
    return (*sides, OpenFloor(floor, first, last, plate), Gate(floor, first, last, plate))


def _edges(scene, section: Section, grid: Grid) -> tuple[int, int]:
    """Columns of the nodes at the edges of the opening; beyond the grid where a wall or the axis bounds it."""
    silo, h = scene.silo, scene.grid.cell_size_m
    if silo.outlet is None:
        return -1, grid.columns
    left, right = (round((edge - section.shift) / h) + MARGIN for edge in silo.outlet_m)
    first = -1 if left <= MARGIN else left
    last = grid.columns if right >= MARGIN + round(section.width / h) else right
    return first, last


def surfaces_of(scene, section: Section) -> tuple[Surface, ...]:
    """Walls of a hopper or an outline that do not follow the grid, and inserts."""
    silo, h = scene.silo, scene.grid.cell_size_m
    angle = None if silo.hopper is None else silo.hopper.friction_angle_deg
    contact, found = side_contact(scene, angle), []
    for name, side, wall in zip(("left", "right"), silo.sides, (0.0, silo.width_m), strict=True):
        foot = polygons.foot(side, wall)
        if foot == 0.0 or (name == "left" and section.round):
            continue
        inclined = _extended(side[side[:, 1] <= foot + polygons.SAME], h)
        upwards = [tuple(place) for place in inclined - (section.shift, 0.0)]
        found.append(Surface(f"hopper_{name}", tuple(upwards if name == "right" else upwards[::-1]), contact))
    for number, insert in enumerate(silo.inserts):
        outline = insert.outline(silo.width_m) - (section.shift, 0.0)
        corners = [tuple(corner) for corner in outline[::-1]]
        found.append(
            Surface(f"insert_{number + 1}", (*corners, corners[0]), side_contact(scene, insert.friction_angle_deg))
        )
    return tuple(found)


def _extended(side: np.ndarray, length: float) -> np.ndarray:
    """A side, from below the floor, which it meets as it goes on above."""
    run, rise = side[1] - side[0]
    slope = run / rise if rise > 0.0 else 0.0
    return np.concatenate([[side[0] - (slope * length, length)], side])


def load(particles: Particles, state: dict[str, np.ndarray]) -> None:
    """Load a state of the fill, of which a law or shape may not need everything."""
    particles.load({name: values for name, values in state.items() if name in particles.names})
