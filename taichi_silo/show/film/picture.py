"""One frame: the sand coloured by a field, beside the force curves up to then."""

import numpy as np

from taichi_silo.runs.point_fields import Scale
from taichi_silo.scene.scene import Scene
from taichi_silo.show.film.canvas import SIZE, Canvas, Course
from taichi_silo.show.film.moments import Moment
from taichi_silo.show.film.point_raster import SandRaster, levels
from taichi_silo.show.report.words import length_unit


class Picture:
    """Draws frames of one silo; Taichi has been started.

    The silo stands between x = 0 and x = its width; its bottom starts at y = 0 and moves down.

    Parameters
    ----------
    scene : of the run.
    scale : of the field.
    course : what the curves are drawn against.
    size : columns and rows of a frame.

    """

    def __init__(self, scene: Scene, scale: Scale, course: Course, size: tuple[int, int] = SIZE):
        silo, self.scale, self.sinks = scene.silo, scale, scene.silo.floor_is_outlet
        sinks_m = scene.flow.displacement_m if self.sinks else 0.0
        self.canvas = Canvas(
            silo.width_m, silo.height_m, scene.weight_N_per_m, scale, title(scene), course, sinks_m, size
        )
        panel = self.canvas.panel
        self.raster = SandRaster(
            panel.columns, panel.rows, self.canvas.pixels_per_metre, self.canvas.top_m, scene.spacing_m, scale.colours,
            () if self.sinks else floors(silo) + silo.solids(),
        )  # fmt: skip

    def frame(self, position: np.ndarray, values: np.ndarray, moment: Moment) -> np.ndarray:
        """Draw one frame, (rows, columns, 3) of bytes.

        Parameters
        ----------
        position : (n, 2) of the points in the laboratory [m]; points that are not finite are left out.
        values : (n,) of the field; those beyond the range take the colour of its end, those that are not finite are
            grey.
        moment : what the frame shows.

        """
        finite = np.isfinite(position).all(axis=1)
        level = levels(self.scale.share(values[finite]))
        plate_top = -moment.progress if self.sinks else -10.0 * self.canvas.top_m
        sand = self.raster.draw(position[finite], level, plate_top, plate_top - self.canvas.plate_m)
        frame = self.canvas.page(moment.time_s, moment.stage, moment.progress)
        frame[self.canvas.panel.slices] = sand
        return frame


def course_of(scene: Scene) -> Course:
    """What the curves of a scene are drawn against."""
    if scene.flow.outflow == "gravity":
        return Course(scene.flow.longest_s, "time since the outlet opened (s)", "open since", "s", 1.0)
    unit, per_m = length_unit(scene.flow.displacement_m)
    what = "bottom displacement u" if scene.silo.floor_is_outlet else "displacement u of the outlet"
    return Course(scene.flow.displacement_m, f"{what} ({unit})", unit=unit, scale=per_m)


def floors(silo) -> list[np.ndarray]:
    """Outlines (n, 2) of the floor beside the outlet [m]."""
    left, right = silo.outlet_m
    deep = -0.1 * silo.height_m
    spans = ((0.0, left), (right, silo.width_m))
    return [np.array([[a, 0.0], [b, 0.0], [b, deep], [a, deep]]) for a, b in spans if b > a]


def title(scene: Scene) -> str:
    """One line that says which sand, walls and silo are seen."""
    walls = "very rough walls"
    if scene.walls.kind == "smooth":
        walls = f"smooth walls ({scene.walls.friction_angle_deg:g}°)"
    words = [f"{scene.sand.name.capitalize()} sand, e₀ = {scene.sand.void_ratio:.2f}", walls, scene.silo.words()]
    return ", ".join(word for word in words if word)
