"""The scenes of the chart: the model silo between smooth, rough and very rough walls, and with openings.

Each is half a silo of 0.2 m × 0.5 m whose bottom, or gate, sinks by 5 mm, between very rough walls by 20 mm; `BASE`
says what all of them share, and about what each dial is turned.
"""

from typing import Any

from taichi_silo.cli.model_silo import SMOOTH_ANGLE_DEG
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Scene

Settings = dict[str, Any]

CELL, SPEED, LENGTH = "grid.cell_size_m", "flow.speed_m_per_s", "averaging.characteristic_length_m"
ROUGH_ANGLE_DEG = 25.0
DENSITIES = {"dense": 0.60, "loose": 0.90}
BASE: Settings = {
    CELL: 0.01, SPEED: 0.008, "flow.displacement_m": 0.005, "silo.half": "yes", "machine.threads": 1,
}  # fmt: skip
VERY_ROUGH_M = 0.02  # of displacement; forces are taken half way, where zones have not softened yet and grids agree
OWN_LENGTH_M = 0.0015  # of the law, 3 d50: on coarse cells between very rough walls the default is longer
SLOW = 0.002  # m/s: the default speed, for which the truth is told


def _walls(kind: str, density: str) -> Settings:
    angle = {"smooth": SMOOTH_ANGLE_DEG[density], "rough": ROUGH_ANGLE_DEG}.get(kind)
    own: Settings = {"walls.kind": "very-rough", "flow.displacement_m": VERY_ROUGH_M}
    if angle is not None:
        own = {"walls.kind": "smooth", "walls.friction_angle_deg": angle}
    return {"sand.void_ratio": DENSITIES[density]} | own


SCENES: dict[str, Settings] = {
    f"{kind} {density}": _walls(kind, density) for kind in ("smooth", "rough", "very-rough") for density in DENSITIES
} | {
    f"{shape} dense": _walls("smooth", "dense") | parts
    for shape, parts in {
        "outlet": {"silo.outlet.width_m": 0.08},
        "hopper": {"silo.hopper.half_angle_deg": 20.0, "silo.hopper.outlet_width_m": 0.08},
        "insert": {
            "silo.outlet.width_m": 0.08,
            "silo.inserts": ({"kind": "roof", "width_m": 0.06, "bottom_m": 0.10},),
        },
    }.items()
}


def scene(name: str, settings: Settings) -> Scene:
    """A scene of the chart with some settings; the whole silo where a setting allows no half.

    Raises BadInput if a setting is not possible.
    """
    values = BASE | SCENES[name] | settings
    try:
        return changed(Scene(), values)
    except ValueError as error:
        if "half" not in str(error):
            raise
        return changed(Scene(), values | {"silo.half": "no"})
