"""Values so far from all that is known that they are likely in another unit: possible, but worth a word."""

import math
from collections.abc import Iterator

from taichi_silo.scene.published_sands import published
from taichi_silo.scene.scene import Scene

FAR = {  # constant: its unit, how many times outside of the published sands it may lie, and which unit is then likely
    "granular_hardness_Pa": ("Pa", 30.0, "kPa"),
    "d50_m": ("m", 100.0, "mm"),
    "grain_density_kg_per_m3": ("kg/m3", 30.0, "kN/m3"),
}
LARGEST_M = 100.0  # of a silo: beyond any that was built
RADIANS = 0.5 * math.pi  # angles of less degrees than this are likely in radians


def of_scene(scene: Scene) -> list[str]:
    """One sentence for each value that is likely in another unit, with its unit and what is usual."""
    return [*_of_silo(scene), *_of_sand(scene), *_angles(scene)]


def _of_silo(scene: Scene) -> Iterator[str]:
    for name in ("width_m", "height_m"):
        length = getattr(scene.silo, name)
        if length > LARGEST_M:
            yield f"silo.{name} is {length:g} m; is it in mm? That would be {1e-3 * length:g} m."


def _of_sand(scene: Scene) -> Iterator[str]:
    for name, (unit, times, other) in FAR.items():
        value = getattr(scene.sand, name)
        known = [table[name] for table in published().values()]
        low, high = min(known), max(known)
        if low / times <= value <= high * times:
            continue
        how = f"{low / value:.2g} times below" if value < low else f"{value / high:.2g} times above"
        yield (
            f"sand.{name} is {value:g} {unit}, {how} every published sand ({low:g} to {high:g} {unit}); is it in "
            f"{other}?"
        )


def _angles(scene: Scene) -> Iterator[str]:
    hopper = scene.silo.hopper
    given: dict[str, float | None] = {
        "walls.friction_angle_deg": scene.walls.friction_angle_deg,
        "walls.bottom_friction_angle_deg": scene.walls.bottom_friction_angle_deg,
    }
    if hopper is not None:
        given["silo.hopper.friction_angle_deg"] = hopper.friction_angle_deg
        given["silo.hopper.half_angle_deg"] = hopper.half_angle_deg
    given |= {
        f"silo.inserts.{k}.friction_angle_deg": one.friction_angle_deg for k, one in enumerate(scene.silo.inserts)
    }
    for name, angle in given.items():
        if angle is not None and 0.0 < angle < RADIANS:
            yield f"{name} is {angle:g} degrees; is it in radians? That would be {math.degrees(angle):.3g} degrees."
