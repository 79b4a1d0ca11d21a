"""What is varied: settings, one at a time about a base, and combinations of them.

A setting is a dotted path into the scene and its value, such as `{"flow.speed_m_per_s": 0.005}`; `precision`, which is
one of the process, and `nudge`, the number of a start perturbation of 1e-12, are named without a dot. What the
scene does not know is left out.
"""

import math
from typing import Literal

from taichi_silo.scene.dotted_paths import known
from taichi_silo.utils.schema import Options

Settings = dict[str, float | int | str | bool]


class VariedSetting(Options):
    """Something to vary: its name, its values (each perhaps of several paths), and what is learnt from it.

    `accuracy`: error against cost; `speed`: whether the residual forces have a limit as the bottom slows.
    """

    name: str
    settings: list[Settings]
    purpose: Literal["accuracy", "speed"] = "accuracy"


class Program(Options):
    """The runs of a chart: the base of all settings, the reference of all errors, and what is varied about the base."""

    base: Settings
    reference: Settings
    varied: dict[str, list[VariedSetting]]  # by walls: very-rough, smooth


def vary(name: str, path: str, *values, purpose: str = "accuracy", **others) -> VariedSetting:
    """One path, several values; `others` are settings that all of them share, with __ for the dot."""
    shared = {key.replace("__", "."): value for key, value in others.items()}
    return VariedSetting(name=name, settings=[{path: value} | shared for value in values], purpose=purpose)


SPEED, CELL, LENGTH = "flow.speed_m_per_s", "grid.cell_size_m", "averaging.characteristic_length_m"
SCATTER = vary("rounding", "nudge", 1, 2)  # runs that differ by nothing else: the floor of every error

METHOD = [
    vary("shape", "grid.shape", "linear", "ugimp", "cpgimp", "cpdi", "bspline"),
    vary("transfer", "method.transfer", "flip", "pic", "blend", "gradient", "apic", "xpic"),
    vary("stress update", "method.stress_update", "last", "first", "modified"),
    vary("filter", "method.stress_filter", "none", "null-space"),
    vary("time step", "method.cfl", 0.07, 0.14, 0.27, 0.41, 0.68, 0.80),  # over h / (c + |v|); 0.55 if not given
    vary("mass scaling", "method.mass_scaling", 1.0, 4.0, 16.0, 100.0),
    vary("noise control", "method.noise_control", "column", "none"),
    vary("precision", "precision", "f64", "mixed", "f32"),
    vary("law", "sand.law", "gudehus-bauer", "intergranular"),
    vary("half model", "silo.half", "no", "yes"),
]


def question(*speeds: float, cell: float = 0.01) -> list[VariedSetting]:
    """Speed after speed of the bottom, as it is and with each possible cause taken away or made stronger."""

    def series(name: str, **others) -> VariedSetting:
        shared = {"grid__cell_size_m": cell} | others
        return vary(f"speed: {name}", SPEED, *speeds, purpose="speed", **shared)

    return [
        series("as it is"),
        series("inertia × 100", method__mass_scaling=100.0),
        series("no noise control", method__noise_control="none"),
        series("cells halved", grid__cell_size_m=0.5 * cell),
        series("non-local, 1.5 cells", averaging__characteristic_length_m=1.5 * cell),
        series("with memory of strain", sand__law="intergranular"),
    ]


SHORT = Program(
    base={CELL: 0.01, SPEED: 0.01, "flow.displacement_m": 0.005},
    reference={CELL: 0.005, SPEED: 0.002},
    varied={
        "very-rough": [
            SCATTER,
            vary("cell size", CELL, 0.02, 0.01, 0.005),
            vary("bottom speed", SPEED, 0.02, 0.01, 0.005, 0.002, 0.001),
            vary("points a cell", "grid.points_per_cell", 1, 4),
            vary("non-local length", LENGTH, 0.0, 0.015),
            *METHOD,
            VariedSetting(name="combined", settings=[{CELL: 0.02, SPEED: 0.02}, {CELL: 0.005, SPEED: 0.005}]),
            *question(0.02, 0.005, 0.001)[:3],
        ],
        "smooth": [
            SCATTER,
            vary("cell size", CELL, 0.02, 0.01, 0.005),
            vary("bottom speed", SPEED, 0.02, 0.01, 0.002),
            vary("noise control", "method.noise_control", "column", "none"),
        ],
    },
)

FULL = Program(
    base={CELL: 0.005, SPEED: 0.005, "flow.displacement_m": 0.01},
    reference={CELL: 0.0025, SPEED: 0.001},
    varied={
        walls: [
            SCATTER,
            vary("cell size", CELL, 0.01, 0.005, 0.0025, 0.00125),
            vary("bottom speed", SPEED, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005),
            vary("points a cell", "grid.points_per_cell", 1, 4, 9),
            vary("non-local length", LENGTH, 0.0, 0.0015, 0.0075, 0.015),
            vary("fine cells, local or not", LENGTH, 0.0, 0.0015, 0.003, grid__cell_size_m=0.0025),
            *METHOD,
            VariedSetting(
                name="combined",
                settings=[{CELL: cell, SPEED: speed} for cell in (0.02, 0.01, 0.0025) for speed in (0.02, 0.01, 0.002)],
            ),
            *(question(0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001) if walls == "very-rough" else []),
        ]
        for walls in ("very-rough", "smooth")
    },
)


def known_to_the_scene(varied: list[VariedSetting]) -> list[VariedSetting]:
    """The varied settings whose paths the scene knows."""
    return [one for one in varied if all(known(path) for setting in one.settings for path in setting)]


UNITS = {"_m_per_s": (1e3, " mm/s"), "_m": (1e3, " mm"), "_s": (1.0, " s")}


def words(setting: Settings) -> str:
    """A setting in a few words, such as `2 mm/s`."""
    return ", ".join(_word(path, value) for path, value in setting.items())


def _word(path: str, value) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return str(value)
    factor, unit = next((pair for ending, pair in UNITS.items() if path.endswith(ending)), (1.0, ""))
    return f"{factor * value:.4g}{unit}"
