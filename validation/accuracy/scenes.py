"""The scenes of the chart: the model silo between smooth, rough and very rough walls, dense and loose, and an outlet.

Each is half a silo of 0.2 m × 0.5 m whose bottom, or gate, sinks by 5 mm; `BASE` says what all of them share, and about
what each dial is turned.
"""

from taichi_silo.cli.model_silo import SMOOTH_ANGLE_DEG
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Scene

Settings = dict[str, float | int | str]

CELL, SPEED, LENGTH = "grid.cell_size_m", "flow.speed_m_per_s", "averaging.characteristic_length_m"
ROUGH_ANGLE_DEG = 25.0
DENSITIES = {"dense": 0.60, "loose": 0.90}
BASE: Settings = {
    CELL: 0.01, SPEED: 0.008, "flow.displacement_m": 0.005, "silo.half": "yes", "machine.threads": 1,
}  # fmt: skip
OWN_LENGTH_M, OF_CELL = 0.0015, 0.5  # between very rough walls, half a cell if that is more
SLOW = 0.002  # m/s: the default speed, for which the truth is told


def _walls(kind: str, density: str) -> Settings:
    angle = {"smooth": SMOOTH_ANGLE_DEG[density], "rough": ROUGH_ANGLE_DEG}.get(kind)
    own: Settings = {"walls.kind": "very-rough"}
    if angle is not None:
        own = {"walls.kind": "smooth", "walls.friction_angle_deg": angle}
    return {"sand.void_ratio": DENSITIES[density]} | own


SCENES: dict[str, Settings] = {
    f"{kind} {density}": _walls(kind, density) for kind in ("smooth", "rough", "very-rough") for density in DENSITIES
} | {"outlet dense": _walls("smooth", "dense") | {"silo.outlet.width_m": 0.08}}


def scene(name: str, settings: Settings) -> Scene:
    """A scene of the chart with some settings; the whole silo where a setting allows no half.

    Raises BadInput if a setting is not possible.
    """
    values = SCENES[name] | BASE | settings
    if "very-rough" in name and LENGTH not in values:
        values[LENGTH] = max(OWN_LENGTH_M, OF_CELL * float(values[CELL]))
    try:
        return changed(Scene(), values)
    except ValueError as error:
        if "half" not in str(error):
            raise
        return changed(Scene(), values | {"silo.half": "no"})
