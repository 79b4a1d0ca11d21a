"""The fields of the points that can be drawn and exported. A new one is one entry of `FIELDS`."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from taichi_silo.analysis.measure.matching import matched
from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Scene

LAYERS = 20  # bands over the height of the fill
MARKED = (0.375, 0.125)  # of the width, from the axis to both sides: where columns of points are marked
ACROSS = 8  # columns of points for each of these
ROUND = 1e-6  # of a spacing: numbers of columns do not hang on round-off
BEYOND = 25.0  # degrees on both sides of the critical friction angle
MOST = 0.995  # quantile at which a range that follows the data ends
NICE = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)  # ends of such ranges, times a power of ten
SLOW = 20.0  # times slower than the fastest: where a tenth of the sand is, a scale of speed is logarithmic


@dataclass(frozen=True)
class Scale:
    """How values become colours, and the words at the colour bar.

    Attributes
    ----------
    label : of the bar, with unit.
    colours : name of a map of matplotlib, or a colour for each class, of which values are the numbers.
    low, high : values at the ends; those beyond take the colour of the end.
    decades : whether the colours follow the logarithm.
    words : at the low and at the high end; of classes, one for each.
    missing : what it means where there is no value; such points are grey.

    """

    label: str
    colours: str | tuple[str, ...]
    low: float
    high: float
    decades: bool = False
    words: tuple[str, ...] = ("", "")
    missing: str = ""

    def share(self, values: np.ndarray) -> np.ndarray:
        """Where values lie between the ends of the scale, 0 to 1; nan stays."""
        ends, values = np.array([self.low, self.high]), np.asarray(values, float)
        if self.decades:
            ends, values = np.log10(ends), np.log10(np.maximum(values, self.low))
        return np.clip((values - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0)


@dataclass(frozen=True)
class Field:
    """A field of the points that can be drawn: a number for each of them.

    Attributes
    ----------
    about : what it is, in a sentence.
    column : the array of a snapshot that holds it, or under which it is exported, with its unit there.
    scale : colours and words; its ends are replaced by `limits`.
    values : of the points of a state (as `Simulation.points` gives them), the start of the run and the scene.
    limits : ends of the scale, from the scene and values of the flow.
    slow : whether, with such values, the scale is logarithmic.

    """

    about: str
    column: str
    scale: Scale
    values: Callable[[dict, dict, Scene], np.ndarray]
    limits: Callable[[Scene, np.ndarray], tuple[float, float]]
    slow: Callable[[np.ndarray], bool] = lambda values: False

    def scaled(self, scene: Scene, values: np.ndarray, limits: tuple[float, float] | None = None) -> Scale:
        """The scale for a scene and values of its flow, or with given ends; logarithmic only above 0."""
        found = np.asarray(values, float)
        found = found[np.isfinite(found)]
        low, high = limits or self.limits(scene, found)
        return replace(self.scale, low=low, high=high, decades=low > 0.0 and bool(len(found)) and self.slow(found))


def field(name: str) -> Field:
    """Return the field of a name.

    Raises
    ------
    BadInput
        if there is no such field.

    """
    if name not in FIELDS:
        raise BadInput(f"field is {name}; it must be one of {', '.join(FIELDS)}")
    return FIELDS[name]


# --- ends of scales ---------------------------------------------------------------------------------------------------


def void_ratio_range(scene: Scene, values: np.ndarray | None = None) -> tuple[float, float]:
    """Ends of the scale: the initial and the critical void ratio, and a little beyond."""
    low, high = sorted((scene.sand.void_ratio, scene.sand.e_c0))
    margin = max(0.1 * (high - low), 0.02)
    return low - margin, high + margin


def to_most(decades: float = 0.0) -> Callable:
    """Ends of the scale: from 0, or so many decades below, to a round number above nearly all values."""

    def limits(scene: Scene, values: np.ndarray) -> tuple[float, float]:
        high = nice(float(np.quantile(values, MOST))) if len(values) else 1.0
        return (high / 10.0**decades if decades else 0.0), high

    return limits


def nice(value: float) -> float:
    """The next round number."""
    if not value > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in NICE if step * power >= value * (1.0 - 1e-9))


def speeds(scene: Scene, values: np.ndarray) -> tuple[float, float]:
    """Ends of the scale of speed: from 0, or from two decades below the upper end where much of the sand is slow."""
    return to_most(2.0 if _much_is_slow(values) else 0.0)(scene, values)


def about_critical(scene: Scene, values: np.ndarray) -> tuple[float, float]:
    """Ends of the scale: as far on both sides of the critical friction angle."""
    angle = scene.sand.critical_friction_angle_deg
    return max(angle - BEYOND, 0.0), angle + min(BEYOND, angle)


def _much_is_slow(values: np.ndarray) -> bool:
    """Whether a tenth of the points is over twenty times slower than the fastest."""
    return bool(len(values)) and SLOW * np.quantile(values, 0.1) < np.quantile(values, MOST)


# --- formulas ---------------------------------------------------------------------------------------------------------


def mean_stress_kpa(points: dict, start: dict, scene: Scene) -> np.ndarray:
    """Mean stress (n,): a third of the trace, compression positive [kPa]."""
    return -1e-3 * points["stress"][:, :3].sum(axis=1) / 3.0


def mobilised_friction_deg(points: dict, start: dict, scene: Scene) -> np.ndarray:
    """Mobilised friction angle (n,) from all three principal stresses [deg]; nan where the sand carries none."""
    xx, yy, zz, xy = -points["stress"].T
    middle, radius = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    high, low = np.maximum(middle + radius, zz), np.minimum(middle - radius, zz)
    carries = xx + yy + zz > 6.0 * scene.law.rest_stress
    ratio = np.divide(high - low, high + low, out=np.full(len(xx), np.nan), where=carries & (high + low > 0.0))
    return np.degrees(np.arcsin(np.clip(ratio, 0.0, 1.0)))


def layers(points: dict, start: dict, scene: Scene) -> np.ndarray:
    """Class (n,) by the place at the start: 0 and 1 in turn for bands of the height, 2 for some columns."""
    x, y = matched(start, points)["position"].T
    spacing = scene.spacing_m
    rows = max(2, round(scene.silo.height_m / (LAYERS * spacing)))
    found, across = np.floor(y / (rows * spacing)) % 2.0, scene.silo.width_m / spacing
    column = np.floor(np.abs(x / spacing - 0.5 * across) + ROUND)  # from the axis
    for part in MARKED[: int(across / ACROSS + ROUND)]:
        found[column == np.floor(part * across + ROUND)] = 2.0
    return found


FIELDS = {
    "void_ratio": Field(
        "volume of voids over volume of grains: dense sand dilates in shear zones, loose sand contracts", "void_ratio",
        Scale("void ratio e", "viridis", 0.0, 1.0, words=("dense", "loose")),
        lambda points, start, scene: points["void_ratio"], void_ratio_range,
    ),
    "strain_path": Field(
        "path length of the strain since the start, the integral of ||D|| dt: shear to and fro adds up", "strain_path",
        Scale("path length of the strain ∫‖D‖ dt (–)", "plasma", 0.0, 1.0),
        lambda points, start, scene: points["path"], to_most(2.0), lambda values: True,
    ),
    "speed": Field(
        "norm of the velocity; logarithmic where much of the sand is slow", "speed_mm_per_s",
        Scale("speed (mm/s)", "cividis", 0.0, 1.0, words=("still", "fast")),
        lambda points, start, scene: 1e3 * np.hypot(*points["velocity"].T), speeds, _much_is_slow,
    ),
    "mean_stress": Field(
        "mean of the three normal stresses, compression positive", "mean_stress_Pa",
        Scale("mean stress (kPa)", "cividis", 0.0, 1.0),
        mean_stress_kpa, to_most(),
    ),
    "mobilised_friction": Field(
        "asin((s1 - s3)/(s1 + s3)) of the largest and the smallest of all three principal stresses",
        "mobilised_friction_deg",
        Scale("mobilised friction angle (°)", "coolwarm", 0.0, 1.0, missing="no stress"),
        mobilised_friction_deg, about_critical,
    ),
    "layers": Field(
        "bands by the height, and some columns by the place of a point at the start: the pattern of the flow", "layer",
        Scale(
            "layers and columns of the fill", ("#E3D5B8", "#B39A6B", "#1F4E79"), 0.0, 2.0,
            words=("layer", "next layer", "column"),
        ),
        layers, lambda scene, values: (0.0, 2.0),
    ),
}  # fmt: skip
