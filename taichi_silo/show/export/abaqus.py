"""Wall loads as a step of Abaqus includes them: by height, and by angle where they differ.

Write `*INCLUDE, INPUT=CASE.inp` within a step for `*DSLOAD` on surfaces, or `CASE_elements.inp` for `*DLOAD` on
element sets of the same names, whose normals then must point outward. The model needs those that `surfaces.csv` lists,
each the inner face of the shell between two heights and two angles, in the coordinates of `wall_loads`: a case that is
the same all round has WALL_B01, WALL_B02, ... from the foot, another one WALL_B01_S01, ... with sectors too; a hopper
HOPPER_B01. `P` is a pressure into the face, so outward on a wall; `TRSHR` a traction along the face, of which the
direction 0, 0, -1 is projected onto it. Units are N and m. The value of a band is the mean over its area, so the
resultant is that of the field, but for the turning of the pressure within a sector: of a patch p cos(theta) 0.6 % of
its force are lost. Nothing here was read by Abaqus itself.
"""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from taichi_silo.show.export.wall_loads import WallLoad

KEYWORDS = {"": "*DSLOAD", "_elements": "*DLOAD"}  # by the end of the file's name
BANDS, SECTORS, SAME = 20, 24, 1e-9
SAMPLES, TURNS = 64, 8  # of a band's mean: heights, angles


def edges(low: float, high: float, count: int, more: tuple[float, ...]) -> np.ndarray:
    """Equal parts of a range, cut at further places too."""
    even = np.linspace(low, high, count + 1)
    found = np.sort(np.concatenate([even, [one for one in more if low < one < high]]))
    return found[np.insert(np.diff(found) > SAME * (high - low), 0, True)]


def bands(load: "WallLoad") -> list[dict]:
    """Surface, heights, angles, and mean pressure and friction of each band, sector after sector, from the foot up."""
    heights = edges(0.0, load.height_m, BANDS, load.cuts_m)
    sectors = [(0.0, 360.0)]
    if not load.symmetrical:
        halves = [(-90.0, 90.0), (90.0, 270.0)]
        sectors = halves if load.section == "plane" else list(pairwise(edges(0.0, 360.0, SECTORS, load.turns_deg)))
    one_angle = load.symmetrical or load.section == "plane"
    parts = np.array([0.5]) if one_angle else (np.arange(TURNS) + 0.5) / TURNS
    z = heights[:-1, None] + np.diff(heights)[:, None] * (np.arange(SAMPLES) + 0.5) / SAMPLES
    weight = load.width_m(z) if load.section == "round" else np.ones_like(z)  # a hopper's girth grows upwards
    weight /= weight.sum(axis=1, keepdims=True)
    found = []
    for turn, (start, end) in enumerate(sectors, 1):
        normal, shear = (
            np.mean(
                [(weight * field(z, float(angle) % 360.0)).sum(axis=1) for angle in start + parts * (end - start)],
                axis=0,
            )
            for field in (load.normal_Pa, load.shear_Pa)
        )
        for number, (low, high) in enumerate(pairwise(heights), 1):
            found.append({
                "surface": f"{load.wall.upper()}_B{number:02d}" + ("" if load.symmetrical else f"_S{turn:02d}"),
                "from_height_m": low, "to_height_m": high, "from_angle_deg": start, "to_angle_deg": end,
                "normal_Pa": float(normal[number - 1]), "shear_Pa": float(shear[number - 1]),
            })  # fmt: skip
    return found


def include_files(load: "WallLoad", about: str) -> tuple[dict[str, str], list[dict]]:
    """Texts of a load's include files by the end of their names, and its surfaces."""
    found = bands(load)
    faces = {"": "pressure into the inner face", "_elements": "pressure outward, along the normals of the elements"}
    texts = {end: _text(load, about, found, keyword, faces[end]) for end, keyword in KEYWORDS.items()}
    surfaces = [{key: value for key, value in one.items() if not key.endswith("_Pa")} for one in found]
    return texts, [{"case": load.case, **one} for one in surfaces]


def _text(load: "WallLoad", about: str, found: list[dict], keyword: str, pressure: str) -> str:
    zero = "the outlet" if load.wall == "hopper" else "the foot of the wall"
    lines = [
        f"** {about}: {load.case}, {load.about}", f"** units N, m, Pa; z upwards from {zero}",
        f"** P: {pressure}; TRSHR: friction of the solid on the wall, downwards", keyword,
    ]  # fmt: skip
    for one in found:
        place = f"z {one['from_height_m']:.6g} to {one['to_height_m']:.6g}"
        if not load.symmetrical:
            place += f", {one['from_angle_deg']:.6g} to {one['to_angle_deg']:.6g} deg"
        lines += [
            f"** {place}", f"{one['surface']}, P, {one['normal_Pa']:.8g}",
            f"{one['surface']}, TRSHR, {one['shear_Pa']:.8g}, 0., 0., -1.",
        ]  # fmt: skip
    return "\n".join(lines) + "\n"
