"""One frame: the sand coloured by a field, beside the force curves up to then."""

import math

import numpy as np

from taichi_silo.runs.point_fields import Scale
from taichi_silo.scene.closed_parts import closed_parts
from taichi_silo.scene.scene import Scene
from taichi_silo.show.film.canvas import Canvas
from taichi_silo.show.film.curves import Course
from taichi_silo.show.film.look import Look, plate_m, view_of
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.point_raster import SandRaster, levels
from taichi_silo.show.report.words import length_unit

WHOLE = Look()


class Picture:
    """Draws frames of one silo; Taichi has been started.

    The silo stands between x = 0 and x = its width; its bottom starts at y = 0 and moves down.

    Parameters
    ----------
    scene : of the run.
    scale : of the field.
    course : what the curves are drawn against.
    look : how it is drawn.
    size : of its page, if it shares that of the look with another run.
    weight_N_per_m : to which the axis of forces reaches, if it is not its own.
    at_most : pixels per metre.
    note : what the curves are, if there is something to say.
    largest_N_per_m : force that the curves reach; their axis ends beyond it.

    """

    def __init__(
        self, scene: Scene, scale: Scale, course: Course, look: Look = WHOLE, size: tuple[int, int] | None = None,
        weight_N_per_m: float = 0.0, at_most: float = math.inf, note: str = "",
        largest_N_per_m: float = 0.0,
    ):  # fmt: skip
        silo, self.scale, self.sinks, self.look = scene.silo, scale, scene.silo.floor_is_outlet, look
        self.plate_m, self.far_below = plate_m(scene), -10.0 * silo.height_m
        view = view_of(scene, look)
        layout = look.page(view, at_most, size)
        seen = view.left < 1e-9, view.right > silo.width_m - 1e-9
        walls = tuple(
            closed_parts(silo, wall) if one else [] for wall, one in zip(("left", "right"), seen, strict=True)
        )
        words = title(scene) if look.title is None else look.title
        weight = max(weight_N_per_m, scene.weight_N_per_m)
        self.canvas = Canvas(layout, view, walls, weight, scale, words, course, note, largest_N_per_m)
        self.raster = SandRaster(
            layout.panel.columns, layout.panel.rows, layout.pixels_per_metre, view.top, scene.spacing_m, scale.colours,
            () if self.sinks else floors(silo) + silo.solids(), view.left,
        )  # fmt: skip

    def frame(self, position: np.ndarray, values: np.ndarray, moment: Moment) -> np.ndarray:
        """Draw one frame, (rows, columns, 3) of bytes, or (rows, columns, 4) if the look is transparent.

        Parameters
        ----------
        position : (n, 2) of the points in the laboratory [m]; points that are not finite are left out.
        values : (n,) of the field; those beyond the range take the colour of its end, those that are not finite are
            grey.
        moment : what the frame shows.

        """
        sand = self.sand(position, values, moment)
        frame = self.canvas.page(moment.shown_s, moment.stage, moment.progress)
        if self.look.transparent:
            frame = without_white(frame)
        frame[self.canvas.panel.slices] = sand
        return frame

    def sand(self, position: np.ndarray, values: np.ndarray, moment: Moment) -> np.ndarray:
        """Draw the part of a frame where the sand is, as `frame` does."""
        finite = np.isfinite(position).all(axis=1)
        level = levels(self.scale.share(values[finite]))
        plate_top = -moment.sunk_m if self.sinks else self.far_below
        given = position[finite], level, plate_top, plate_top - self.plate_m
        if not self.look.transparent:
            return self.raster.draw(*given)
        colour, cover = self.raster.see_through(*given)
        return np.dstack([colour, np.rint(255.0 * cover).astype(np.uint8)])


def without_white(frame: np.ndarray) -> np.ndarray:
    """An image (rows, columns, 4) that looks like this one (rows, columns, 3) on white, and is clear where it is white.

    Each pixel covers as little as its darkest channel allows.
    """
    cover = 255.0 - frame.min(axis=2).astype(float)
    colour = 255.0 * (1.0 - (255.0 - frame) / np.maximum(cover, 1.0)[..., None])
    return np.rint(np.dstack([np.where(cover[..., None] > 0.0, colour, 0.0), cover])).astype(np.uint8)


def course_of(scene: Scene) -> Course:
    """What the curves of a scene are drawn against."""
    per = "metre of girth" if scene.silo.section == "round" else "metre run"
    if scene.flow.outflow == "collapse":
        return Course(scene.flow.longest_s, "time since the walls were taken away (s)", "free since", "s", 1.0, per=per)
    if scene.flow.free:
        return Course(scene.flow.longest_s, "time since the outlet opened (s)", "open since", "s", 1.0, per=per)
    unit, per_m = length_unit(scene.flow.displacement_m)
    what = "bottom displacement u" if scene.silo.floor_is_outlet else "displacement u of the outlet"
    return Course(scene.flow.displacement_m, f"{what} ({unit})", unit=unit, scale=per_m, per=per)


def floors(silo) -> list[np.ndarray]:
    """Outlines (n, 2) of the floor beside the outlets [m]."""
    deep, (first, last) = -0.1 * silo.height_m, silo.floor_m
    parts = [(0.0, first), *closed_parts(silo, "floor"), (last, silo.width_m)]  # beside the floor stands a hopper
    return [np.array([[a, 0.0], [b, 0.0], [b, deep], [a, deep]]) for a, b in parts if b > a]


def title(scene: Scene) -> str:
    """One line that says which sand, walls and silo are seen."""
    first, *others = scene.sand.words.split(", ")
    sand = f"{first.capitalize()} sand, e₀ = {scene.sand.void_ratio:.2f}"
    words = [sand, *others, scene.walls.words, scene.silo.words()]
    return ", ".join(word for word in words if word)
