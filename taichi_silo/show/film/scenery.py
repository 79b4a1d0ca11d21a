"""The picture of a scene: its silo, its title, and what its curves are drawn against."""

import numpy as np

from taichi_silo.runs.point_fields import Scale
from taichi_silo.show.film.canvas import SIZE, Course
from taichi_silo.show.film.picture import Picture


def picture(scene, scale: Scale, size: tuple[int, int] = SIZE, course: Course | None = None) -> Picture:
    """What draws the frames of a scene's run; Taichi has been started.

    Parameters
    ----------
    scene : of the run.
    scale : of the field.
    size : columns and rows.
    course : what the curves are drawn against; that of the scene if absent.

    """
    silo = scene.silo
    return Picture(
        width_m=silo.width_m,
        height_m=silo.height_m,
        displacement_m=scene.flow.displacement_m,
        spacing_m=scene.spacing_m,
        weight_N_per_m=scene.weight_N_per_m,
        scale=scale,
        title=title(scene),
        course=course or course_of(scene),
        solids=None if silo.floor_is_outlet else floors(silo) + silo.solids(),
        size=size,
    )


def course_of(scene) -> Course:
    """What the curves are drawn against."""
    if scene.flow.outflow == "gravity":
        return Course(scene.flow.longest_s, "time since the outlet opened (s)", "open since", "s", 1.0)
    if scene.silo.floor_is_outlet:
        return Course(scene.flow.displacement_m)
    return Course(scene.flow.displacement_m, "displacement u of the outlet (mm)")


def floors(silo) -> list[np.ndarray]:
    """Outlines of the floor beside the outlet [m]."""
    left, right = silo.outlet_m
    deep = -0.1 * silo.height_m
    spans = ((0.0, left), (right, silo.width_m))
    return [np.array([[a, 0.0], [b, 0.0], [b, deep], [a, deep]]) for a, b in spans if b > a]


def title(scene) -> str:
    """What is seen."""
    walls = "very rough walls"
    if scene.walls.kind == "smooth":
        walls = f"smooth walls ({scene.walls.friction_angle_deg:g}°)"
    silo = scene.silo.words()
    words = [f"{scene.sand.name.capitalize()} sand, e₀ = {scene.sand.void_ratio:.2f}", walls, silo]
    return ", ".join(word for word in words if word)
