"""Half of a symmetric silo stands for the whole: when it may, and how the other half is made from it.

The left half is computed, up to the axis at half the width (`half.py`). Points and wall forces of the right half are
its mirror image, so that whoever looks sees the whole silo.
"""

from typing import TYPE_CHECKING

import numpy as np

from taichi_silo.scene import bands, fill_shape

if TYPE_CHECKING:
    from taichi_silo.scene.scene import Scene

FEWEST_CELLS = 4  # across the silo: less, and the half is a single column of cells
# largest difference of P, T or N between half and whole, over the weight, with very rough walls: loose sand on 10 mm
# cells, bottom at 10 mm/s, u = 10 mm (dense: 0.0044 on 5 mm cells at 2 mm/s, u = 5 mm). Nothing but round-off makes it.
SCATTER = 0.021
# height over width from which sand between smooth walls may sway: at 12.5 (5 mm cells, u = 2 mm) a half, which cannot,
# has 2.4 % less N in flow than the whole, whose void ratio falls by 0.017 instead of 0.003; at 6.25 both are equal
SLENDER = 6.25
SIGNS = {  # of the components of a point's fields in a mirror at constant x
    "velocity": (-1.0, 1.0),
    "stress": (1.0, 1.0, 1.0, -1.0),
    "intergranular": (1.0, 1.0, 1.0, -1.0),
    "domain": (1.0, -1.0, -1.0, 1.0),
    "affine": (1.0, -1.0, -1.0, 1.0),
}


def half_model(scene: "Scene") -> tuple[bool, str]:
    """Whether half of a scene is computed, and a sentence about it.

    Raises ValueError if the half is asked for and would not be the half of that whole.
    """
    obstacle = _obstacle(scene)
    if scene.silo.half == "yes" and obstacle:
        raise ValueError(f"half is yes; {obstacle}, so it must be auto or no")
    if scene.silo.section == "round":
        return False, f"The section from axis to wall is computed: {scene.points // 2} of {scene.points} points."
    points = f"{scene.points // 2} of {scene.points} points"
    if scene.silo.half == "no":
        return False, f"The whole silo is computed, as asked for: {scene.points} points."
    if scene.silo.half == "yes":
        return True, f"Half of the silo is computed, as asked for: {points}."
    if obstacle:
        return False, f"The whole silo is computed: {obstacle}."
    if scene.walls.kind == "very-rough":
        return False, (
            "The whole silo is computed: shear zones at very rough walls amplify round-off, and P, T, N of half and "
            f"whole differ by up to {100.0 * SCATTER:.2g} % of the weight."
        )
    if scene.silo.column_m is not None:
        return False, "The whole silo is computed: a collapse need not be symmetric, though column and sand are."
    if not scene.silo.floor_is_outlet:
        return False, "The whole silo is computed: flow to an outlet need not be symmetric, though silo and sand are."
    slenderness = scene.silo.height_m / scene.silo.width_m
    if slenderness > SLENDER:
        return False, (
            f"The whole silo is computed: it is {slenderness:.3g} times as high as wide, and beyond {SLENDER} the sand "
            "may sway from wall to wall, which a half cannot."
        )
    return True, f"Half of the silo is computed, silo and sand being symmetric: {points}."


def _obstacle(scene: "Scene") -> str:
    """Why a half, made by this method, would not be the half of the whole; empty if nothing stands against it."""
    silo = scene.silo
    if silo.section == "round":
        return "the section of a round silo is half of it already"
    if not silo.one_opening:
        return "several outlets, or one of a side wall or that opens later, are computed whole"
    if silo.outlets and silo.outlets[0].position != "centre":
        return f"the outlet's position is {silo.outlets[0].position}"
    if silo.cuts_cells:
        return "hoppers, outlines and inserts are computed whole"
    if not bands.alike(scene.walls):
        return f"the walls are not alike ({bands.words(scene.walls)})"
    if not fill_shape.symmetric(silo):
        return "column and surface of the fill are not symmetric"
    cells = round(silo.width_m / scene.grid.cell_size_m)
    if cells % 2 or cells < FEWEST_CELLS:
        return f"{cells} cells across have no half (an even number of at least {FEWEST_CELLS} has)"
    kernel, _ = scene.averaging.kernel(scene.characteristic_length_m, scene.spacing_m)
    if kernel is not None and scene.averaging.summed_by(kernel, scene.spacing_m, half=True) == "rows":
        return f"the non-local average, {1e3 * kernel.length_m:g} mm long, is summed over neighbours across the axis"
    if scene.method.stress_filter not in ("none", "patch", "auto"):
        return f"the {scene.method.stress_filter} filter averages across the axis"
    return ""


def whole_points(half: dict[str, np.ndarray], width_m: float) -> dict[str, np.ndarray]:
    """Fields of the points of both halves, the mirror images last; the silo stands between 0 and `width_m`."""
    whole = {}
    for name, values in half.items():
        if name == "position":
            image = np.array([width_m, 0.0]) + values * (-1.0, 1.0)
        elif name == "identity":
            image = -1 - values
        else:
            image = values * SIGNS.get(name, 1.0)
        whole[name] = np.concatenate([values, image])
    return whole
