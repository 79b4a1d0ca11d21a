"""What is turned, one dial at a time about the base of all scenes, and the named settings of `taichi-silo`."""

from taichi_silo.scene.fidelity import FIDELITIES, fidelity
from taichi_silo.scene.scene import Scene
from validation.accuracy.scenes import CELL, LENGTH, OWN_LENGTH_M, SPEED, Settings

BASE_DIAL, FINE, SLOW, NAMED = "base", "fine cells", "bottom speed", "fidelity"
SPEEDS = (0.016, 0.008, 0.004, 0.002)
TYPICAL = ("very-rough dense",)  # the scene in which every part of the method is varied
MEANS = "averaging.means"  # by a grid, which a half model allows
UNITS = {"_m_per_s": (1e3, " mm/s"), "_m": (1e3, " mm")}


def _values(path: str, *values) -> list[Settings]:
    return [{path: value} for value in values]


def _lengths(cell: float, *shares: float) -> list[Settings]:
    return [{CELL: cell, LENGTH: share * cell, MEANS: "grid"} for share in shares]


GRIDS_M = {  # of the runs from which the truth of a scene is extrapolated; thin shear zones need fine ones
    "very-rough": (0.0025, 0.002, 0.00153846154),
    "outlet": (0.01, 0.005, 0.004), "hopper": (0.01, 0.005, 0.004), "insert": (0.01, 0.005, 0.004),
    "": (0.02, 0.01, 0.005),
}  # fmt: skip
CELLS, LOCAL, LENGTHS = "cells", "cells of a local law", "length on 10 mm cells"
WALL = "walls in the mean"
OF_VERY_ROUGH = (LOCAL, LENGTHS, WALL)  # dials that turn nothing between other walls, where sand shears nowhere
DIALS: dict[str, list[Settings]] = {
    CELLS: _values(CELL, 0.02, 0.01, 0.005),
    LOCAL: [{CELL: cell, LENGTH: 0.0} for cell in (0.02, 0.01, 0.005)],
    LENGTHS: _lengths(0.01, 0.5, 0.7, 1.0, 2.0),
    SLOW: _values(SPEED, *SPEEDS),
    "points a cell": _values("grid.points_per_cell", 1, 4),
    WALL: [{"averaging.wall": wall} | _lengths(0.01, 1.0)[0] for wall in ("ignored", "rigid")],
}
CHANGES = {  # of a part of the method: the two settings between which it is told what it changes
    "non-local average": ((LOCAL, "10 mm, 0 mm"), (BASE_DIAL, "all as it is")),
    "points a cell": (("points a cell", "1"), ("points a cell", "4")),
}
METHOD: dict[str, list[Settings]] = {
    "shape": _values("grid.shape", "linear", "ugimp", "cpgimp", "cpdi", "bspline"),
    "transfer": _values("method.transfer", "flip", "pic", "blend", "gradient", "apic", "xpic"),
    "stress update": _values("method.stress_update", "last", "first", "modified"),
    "filter": _values("method.stress_filter", "patch", "none", "null-space"),
    "time step": _values("method.cfl", 0.14, 0.27, 0.41),
    "mass scaling": _values("method.mass_scaling", 1.0, 4.0, 16.0, 100.0),
    "noise control": _values("method.noise_control", "column", "none"),
    "law": _values("sand.law", "gudehus-bauer", "intergranular"),
}


def settings(setting: Settings, scene: Scene) -> Settings:
    """The values of a setting in a scene, those of a named one included."""
    if "fidelity" in setting:
        return dict(fidelity(str(setting["fidelity"])).values(scene))
    return setting


def dials() -> dict[str, list[Settings]]:
    """All dials; the first is the base, the last the named settings."""
    named: list[Settings] = [{"fidelity": name} for name in FIDELITIES]
    return {BASE_DIAL: [{}], FINE: [], **DIALS, **METHOD, NAMED: named}


def turned(dial: str, scene: str, full: bool = False) -> list[Settings]:
    """The settings of a dial in a scene; none where it has no meaning, or, if not `full`, is measured in another."""
    elsewhere = dial in METHOD and scene not in TYPICAL and not full
    if elsewhere or dial in OF_VERY_ROUGH and "very-rough" not in scene:
        return []
    if dial == FINE:
        grids = next(grids for kind, grids in GRIDS_M.items() if kind in scene)
        return [{CELL: cell, LENGTH: OWN_LENGTH_M} if "very-rough" in scene else {CELL: cell} for cell in grids]
    if dial == NAMED and scene not in TYPICAL:
        return dials()[dial][:2]  # the others are as fine as what tells the truth there
    return dials()[dial]


def words(setting: Settings) -> str:
    """A setting in a few words, such as `2 mm/s`."""
    return ", ".join(_word(path, value) for path, value in setting.items() if path != MEANS) or "all as it is"


def _word(path: str, value) -> str:
    if isinstance(value, str):
        return value
    factor, unit = next((pair for ending, pair in UNITS.items() if path.endswith(ending)), (1.0, ""))
    return f"{factor * value:.4g}{unit}"
