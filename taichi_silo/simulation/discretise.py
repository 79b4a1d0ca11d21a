"""From a scene to the model of its silo: points, grid and walls in the frame of the grid."""

import functools
import math

import numpy as np

from taichi_silo.mpm.contracts import Law, Wall
from taichi_silo.mpm.frozen import replaced
from taichi_silo.mpm.grid import MARGIN, Grid
from taichi_silo.mpm.laws.several import are_several
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.nonlocal_average import NonLocal, Weight
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.runtime import threads
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.walls import Coulomb, Edges, Frictionless, Gate, Gates, NoSlip, OpenFloor, PlaneWall, Surface
from taichi_silo.mpm.walls.outlets import FloorRow, pace_of_edge
from taichi_silo.mpm.walls.side_outlets import SideColumn
from taichi_silo.scene import fill_shape, polygons, touching
from taichi_silo.scene.outlets import Opening
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation import filling, outflow
from taichi_silo.simulation.gates import gated
from taichi_silo.simulation.model import Model
from taichi_silo.simulation.section import Section
from taichi_silo.simulation.time_scales import noise_control, period_of, wave_speed_of
from taichi_silo.simulation.wall_forces import BOTTOM, LEFT, RIGHT, WallForces
from taichi_silo.simulation.wall_friction import banded, of_surface

HEADROOM = 0.1  # of the fill height, free above it; more where sand hangs on a very rough wall while the grid sinks

FADE = 0.05  # of the width: height of a very rough wall over which the velocity goes from the sinking bottom's to zero


def discretise(scene: Scene, control: NoiseControl | None = None) -> Model:
    """The model of a scene, with the noise control that it asks for or another; Taichi has been started."""
    section, law, method = Section.of(scene), scene.law, scene.method
    shape = SHAPES[scene.grid.shape](0.5 / math.isqrt(scene.grid.points_per_cell))
    density = law.grain_density / (1.0 + scene.mean_void_ratio)
    grid = grid_of(scene, section, threads())
    fill = fill_of(scene, section, law)
    particles = Particles(len(fill["mass"]), Particles.extras(law, shape, method.transfer_of_points()))
    particles.load(fill)
    mass = section.factor * float(fill["mass"].sum())
    del fill
    kernel, about_averaging = scene.averaging.kernel(scene.characteristic_length_m, scene.spacing_m)
    openings = openings_of(scene, section)
    (walls, gates), surfaces = walls_of(scene, section, grid), surfaces_of(scene, section)
    period = period_of(scene)
    return Model(
        scene=scene,
        section=section,
        law=law,
        shape=shape,
        spacing=scene.spacing_m,
        density=density,
        gravity=method.gravity_m_per_s2 / method.mass_scaling,
        wave_speed=wave_speed_of(scene),
        period=period,
        filling_time=filling.duration(scene, period),
        flow_time=outflow.duration(scene, period),
        control=noise_control(scene, period) if control is None else control,
        fill=functools.partial(fill_of, scene, section, law),
        mass=mass,
        particles=particles,
        grid=grid,
        averaging=averaging_of(scene, section, kernel, particles, grid, walls),
        about_averaging=about_averaging,
        walls=walls,
        surfaces=surfaces,
        wall_forces=WallForces(section, paces(walls, grid), tuple(surface.name for surface in surfaces), *told(walls)),
        openings=openings,
        gates=gates,
    )


# --- grid and points --------------------------------------------------------------------------------------------------


def headroom(scene: Scene) -> float:
    """Height of the grid above the fill [m]."""
    h, room = scene.grid.cell_size_m, HEADROOM * scene.silo.height_m
    if scene.silo.floor_is_outlet:
        room = max(room, scene.flow.displacement_m)
    if scene.filling.kind == "rain":
        room = max(room, scene.filling.drop_m)
    return room + 2.0 * h


def rows_of_cells(scene: Scene) -> int:
    """How many the grid has, from the floor to its top."""
    return math.ceil((scene.silo.height_m + headroom(scene)) / scene.cell_height_m - 1e-9)


def grid_of(scene: Scene, section: Section, copies: int) -> Grid:
    """The grid: it sinks with the bottom where all of that sinks, else it stands still."""
    h, high = scene.grid.cell_size_m, scene.cell_height_m
    follows = "bottom" if scene.silo.floor_is_outlet else "nothing"
    beside = any(not one.in_floor for one in scene.silo.openings)
    return Grid(
        section.width, rows_of_cells(scene) * high, h, copies=copies, follows=follows, open_sides=beside,
        cell_height_m=high,
    )  # fmt: skip


def fill_of(scene: Scene, section: Section, law: Law) -> dict[str, np.ndarray]:
    """Fields of the points of the full silo, row after row from the floor, without stress."""
    d, rise = scene.spacing_m, scene.rise_m
    x, y, volume = scene.silo.lattice(d, rise)
    computed = (x > section.shift) & (x < section.shift + section.width)
    x, y, volume = x[computed] - section.shift, y[computed], volume[computed]
    count, wide, volume = len(x), volume / rise, volume * section.geometry.depth(x)
    density = law.grain_density / (1.0 + scene.sand.void_ratio_at(y))
    state = {
        "position": np.stack([x, y], axis=1),
        "velocity": np.broadcast_to(0.0, (count, 2)),  # what all points have alike takes no room
        "stress": np.broadcast_to([-law.rest_stress] * 3 + [0.0], (count, 4)),
        "mass": density * volume,
        "volume": volume,
        "path": np.broadcast_to(0.0, count),
    }
    if SHAPES[scene.grid.shape].DOMAIN:  # domains fill the row between its walls, without gaps
        nothing = np.zeros(count)
        state["domain"] = np.column_stack([wide, nothing, nothing, nothing + rise])
    if are_several(law):
        state["sand"] = scene.sand.sand_at(y).astype(float)
    if law.REMEMBERS:  # the last strain is that of filling: vertical compression
        radius = law.radius  # type: ignore[attr-defined]
        state["intergranular"] = np.broadcast_to([0.0, -radius, 0.0, 0.0], (count, 4))
    return state


def averaging_of(
    scene: Scene, section: Section, kernel: Weight | None, particles: Particles, grid: Grid, walls: tuple[Wall, ...]
) -> NonLocal | None:
    """The non-local average, in which walls of no slip count if the scene wants it."""
    if kernel is None:
        return None
    planes = [wall.plane(grid) for wall in walls if isinstance(wall, PlaneWall) and isinstance(wall.contact, NoSlip)]
    return NonLocal(
        kernel, particles, scene.spacing_m, rigid_planes=planes if scene.averaging.walls_count else (), grid=grid,
        mirrored=section.half, by=scene.averaging.summed_by(kernel, scene.spacing_m, section.half),
    )  # fmt: skip


def openings_of(scene: Scene, section: Section) -> tuple[Opening, ...]:
    """Where sand leaves, in the frame of the grid; none where the whole floor sinks."""
    return () if not scene.silo.has_opening else tuple(one.shifted(section.shift) for one in scene.silo.openings)


def walls_of(scene: Scene, section: Section, grid: Grid) -> tuple[tuple[Wall, ...], Gates | None]:
    """Left, right, bottom; or left, right, and floor, edges (both empty above an open hopper) and gate.

    Of several outlets, or one of a side wall or that opens later, edges and gate of each, and what moves them. Of a
    column left, right, the walls that are taken away, and bottom: they recede faster than the sand can follow, and come
    before the bottom, whose friction else takes from them what it does not take from the others.
    """
    silo, h, side = scene.silo, scene.cell_height_m, scene.walls.contact()
    low = tuple(MARGIN + math.ceil(foot / h - 1e-9) if foot else 0 for foot in silo.feet_m)
    left, right = grid.node_along(0.0), grid.node_along(section.width)
    axis = Frictionless()
    sides: tuple[PlaneWall, ...] = (
        PlaneWall("axis", 0, -1, left, axis) if section.round else PlaneWall("left", 0, -1, left, side, lowest=low[0]),
        PlaneWall("axis", 0, 1, right, axis) if section.half else PlaneWall("right", 0, 1, right, side, lowest=low[1]),
    )
    plate = Coulomb(scene.walls.bottom_friction_angle_deg)
    floor = grid.node_along(0.0)
    # in the corner the floor bears the sand: a wall of no slip would hold it, and where the bottom sinks pull it down
    sides = tuple(replaced(wall, bears_from=floor + 1) if isinstance(wall.contact, NoSlip) else wall for wall in sides)
    sides = banded(sides, scene.walls, grid)
    if silo.floor_is_outlet:
        fade = max(1.0, FADE * silo.width_m / h)
        rough = not any(band.from_m < fade * h for band in scene.walls.bands)
        fading = [replaced(wall, fade=fade) if rough and isinstance(wall.contact, NoSlip) else wall for wall in sides]
        return (*fading, PlaneWall("bottom", 1, -1, floor, plate, motion=(0.0, 1.0))), None
    if silo.column_m is not None:
        return (*sides, *_free_walls(scene, section, grid), PlaneWall("bottom", 1, -1, floor, plate)), None
    if not silo.one_opening:
        return gated(sides, openings_of(scene, section), grid, plate, scene.flow.outflow == "controlled")
    first, last = _edges(scene, section, grid)
    pace = pace_of_edge(last - MARGIN if section.round else None, math.isqrt(scene.grid.points_per_cell))
    edges = Edges(floor, first, last, plate, motion=(0.0, pace))
    return (*sides, OpenFloor(floor, first, last, plate), edges, Gate(floor, first, last, plate)), None


def told(walls: tuple[Wall, ...]) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """To which wall of the silo each of the solver's walls belongs, and its horizontal pace (see `WallForces`)."""
    lines = [wall for wall in walls if isinstance(wall, PlaneWall | FloorRow | SideColumn)]
    owners = tuple(BOTTOM if wall.axis == 1 else LEFT if wall.side < 0 else RIGHT for wall in lines)
    return owners, tuple(wall.motion[0] for wall in walls) if any(wall.motion[0] for wall in walls) else ()


def _free_walls(scene: Scene, section: Section, grid: Grid) -> list[PlaneWall]:
    """The smooth walls that hold a column until it collapses."""
    found = []
    for name, side, place, free in zip(
        ("free_left", "free_right"), (-1, 1), fill_shape.sides_m(scene.silo), fill_shape.free_walls(scene.silo),
        strict=True,
    ):  # fmt: skip
        inside = 0.0 < place - section.shift < section.width
        if free and inside:
            node = grid.node_along(place - section.shift)
            found.append(PlaneWall(name, 0, side, node, Coulomb(), motion=(-float(side), 0.0)))
    return found


def paces(walls: tuple[Wall, ...], grid: Grid) -> np.ndarray:
    """Vertical velocity of the walls (walls, slots), as multiples of the speed at which the sand is let out."""
    slots = max(grid.columns, grid.rows)
    found = np.repeat([[wall.motion[1]] for wall in walls], slots, axis=1)
    for number, wall in enumerate(walls):
        if isinstance(wall, PlaneWall) and wall.fade:
            found[number] = [wall.followed(j) for j in range(slots)]
    return found


def _edges(scene: Scene, section: Section, grid: Grid) -> tuple[int, int]:
    """Columns of the nodes at the edges of the opening; beyond the grid where a wall or the axis bounds it."""
    silo, h = scene.silo, scene.grid.cell_size_m
    if silo.outlet is None:
        return -1, grid.columns
    left, right = (round((edge - section.shift) / h) + MARGIN for edge in silo.outlet_m)
    first = -1 if left <= MARGIN else left
    last = grid.columns if right >= MARGIN + round(section.width / h) else right
    return first, last


def surfaces_of(scene: Scene, section: Section) -> tuple[Surface, ...]:
    """Walls of a hopper or an outline that do not follow the grid, and inserts."""
    silo, h = scene.silo, scene.grid.cell_size_m
    angle = None if silo.hopper is None else silo.hopper.friction_angle_deg
    contact, found = scene.walls.contact(angle), []
    for name, side, wall in zip(("left", "right"), silo.sides, (0.0, silo.width_m), strict=True):
        foot = polygons.foot(side, wall)
        if foot == 0.0 or (name == "left" and section.round):
            continue
        inclined = _extended(side[side[:, 1] <= foot + polygons.SAME], h)
        parts = touching.uncovered(silo, inclined if name == "right" else inclined[::-1])
        if not parts:  # bodies cover it
            continue
        surface = Surface(f"hopper_{name}", _line(parts, section), contact, _gaps(parts))
        found.append(surface if angle is not None else of_surface(surface, name, scene.walls))
    for number, insert in enumerate(silo.inserts):
        outline = touching.free_outline(silo, insert)[::-1]
        own = scene.walls.contact(insert.friction_angle_deg)
        found.append(Surface(f"insert_{number + 1}", _line([outline], section), own))
    return tuple(found)


def _line(parts: list[np.ndarray], section: Section) -> tuple[tuple[float, float], ...]:
    """Corners of a line of parts, in the frame of the grid [m]."""
    return tuple((float(x), float(y)) for x, y in np.concatenate(parts) - (section.shift, 0.0))


def _gaps(parts: list[np.ndarray]) -> tuple[int, ...]:
    """Numbers of the sides of such a line that lie between its parts."""
    return tuple(int(end) - 1 for end in np.cumsum([len(part) for part in parts])[:-1])


def _extended(side: np.ndarray, length: float) -> np.ndarray:
    """A side, from below the floor, which it meets as it goes on above."""
    run, rise = side[1] - side[0]
    slope = run / rise if rise > 0.0 else 0.0
    return np.concatenate([[side[0] - (slope * length, length)], side])
