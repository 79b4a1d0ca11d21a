"""What figures and reports need from a run's folder. Whatever file is missing or damaged reads as empty."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.analysis.theory.eurocode import EurocodeSilo
from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.errors import BadInput
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.runs.snapshot import figured
from taichi_silo.runs.theories import eurocode_of
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.silo import Silo
from taichi_silo.utils import bounded_reading, vtu

GRAVITY = 9.81  # m/s2
TABLE_PRESSURE_RATIO = 0.45  # sand, EN 1991-4 table E.1
REST_SPAN_S = 0.05  # the end of the filling stage over which the state at rest is averaged
FORCES = (
    "time_s", "stage", "displacement_m", "bottom_force_N_per_m", "left_normal_N_per_m", "left_shear_N_per_m",
    "right_normal_N_per_m", "right_shear_N_per_m", "wall_friction_angle_deg", "weight_N_per_m",
)  # fmt: skip
WALLS = ("state", "wall", "height_m", "normal_stress_Pa", "shear_stress_Pa")
SNAPSHOTS = ("file", "stage", "time_s", "displacement_m")
WORDS = ("stage", "state", "wall", "file")  # columns that hold no numbers


@dataclass(frozen=True)
class RunFiles:
    """The files of one run.

    Attributes
    ----------
    folder : Path
        Where they are.
    label : str
        Name of the run in legends.
    parameters, summary : dict
        `run.toml` and `summary.json`.
    forces, walls, snapshots : DataFrame
        `forces.csv`, `walls.csv` and `snapshots/index.csv`, less the snapshots that only films need.
    trouble : tuple of str
        A sentence for each file that is there and cannot be read.
    """

    folder: Path
    label: str
    parameters: dict
    summary: dict
    forces: pd.DataFrame
    walls: pd.DataFrame
    snapshots: pd.DataFrame
    trouble: tuple[str, ...] = ()

    @classmethod
    def read(cls, folder: Path, label: str = "") -> "RunFiles":
        """Read the small files of a run; snapshots are read on demand."""
        folder, trouble = Path(folder), []
        return cls(
            folder=folder,
            label=label or folder.resolve().name,
            parameters=_tables(folder / "run.toml", lambda file: bounded_reading.toml(file, "a run"), trouble),
            summary=_tables(folder / "summary.json", bounded_reading.tables, trouble),
            forces=_table(folder / "forces.csv", FORCES, trouble),
            walls=_table(folder / "walls.csv", WALLS, trouble),
            snapshots=figured(_table(folder / "snapshots/index.csv", SNAPSHOTS, trouble)),
            trouble=tuple(trouble),
        )

    def parameter(self, table: str, name: str, default=None):
        """Return a value of `run.toml`."""
        found = self.parameters.get(table)
        return found.get(name, default) if isinstance(found, dict) else default

    @property
    def wall_kind(self) -> str:
        """Kind of the walls: "smooth", "very-rough" or what else the run names."""
        return self.parameter("walls", "kind", "")

    @property
    def void_ratio(self) -> float:
        """Initial void ratio; nan if unknown."""
        return self.parameter("sand", "void_ratio", float("nan"))

    @property
    def loose(self) -> bool:
        """Whether the sand is looser than its critical void ratio without pressure, so that shear contracts it."""
        return self.void_ratio > self.parameter("sand", "e_c0", Sand.model_fields["e_c0"].default)

    @property
    def title(self) -> str:
        """One line that says which sand and which walls."""
        words = []
        if np.isfinite(self.void_ratio):
            words.append(sand_title(self))
        angle = self.parameter("walls", "friction_angle_deg")
        if self.wall_kind == "smooth" and angle is not None:
            words.append(f"smooth walls ({angle:g}°)")
        elif self.wall_kind:
            words.append(self.wall_kind.replace("-", " ") + " walls")
        if special := self.silo.words():
            words.append(special)
        if self.free:
            words.append("free outflow")
        return ", ".join(words) or self.label

    @cached_property
    def filling(self) -> pd.DataFrame:
        """Rows of `forces.csv` while the silo is filled."""
        return self.forces[self.forces["stage"] == "filling"]

    @cached_property
    def flow(self) -> pd.DataFrame:
        """Rows of `forces.csv` while the bottom sinks."""
        return self.forces[self.forces["stage"] == "flow"]

    @property
    def filled(self) -> pd.Series | None:
        """Median of the last rows of the filling stage, or None."""
        if self.filling.empty:
            return None
        last = self.filling["time_s"] > self.filling["time_s"].iloc[-1] - REST_SPAN_S
        return self.filling[last].median(numeric_only=True)

    @property
    def wall_angle_deg(self) -> float | None:
        """Friction angle along the walls: the wall's own, or of critical simple shear at very rough walls."""
        if self.wall_kind == "very-rough":
            critical = self.parameter("sand", "critical_friction_angle_deg")
            return None if critical is None else critical_simple_shear_angle_deg(critical)
        return self.parameter("walls", "friction_angle_deg")

    @property
    def pressure_ratios(self) -> dict[str, float]:
        """Pressure ratios for Janssen's theory by origin: the law's and the measured one, or a table's."""
        stored = self.summary.get("janssen", {})
        names = {"K0 of the law": "pressure_ratio_K0", "measured K": "pressure_ratio_measured"}
        known = {origin: stored[key] for origin, key in names.items() if (stored.get(key) or 0.0) > 0.0}
        return known or {"K of EN 1991-4": TABLE_PRESSURE_RATIO}

    def janssen(self, pressure_ratio: float) -> Janssen | None:
        """Return Janssen's theory of this silo, or None if the run does not say enough about itself.

        Its friction angle is the one stored with the pressure ratios, for very rough walls the mobilised one.
        """
        width, height = self.parameter("silo", "width_m"), self.parameter("silo", "height_m")
        density, angle = self.parameter("sand", "grain_density_kg_per_m3"), self.wall_angle_deg
        stored = self.summary.get("janssen", {}).get("wall_friction_angle_deg")
        if stored is not None and 0.0 <= stored < 90.0:
            angle = stored
        if None in (width, height, density, angle) or not np.isfinite(self.void_ratio):
            return None
        gravity = self.parameter("method", "gravity_m_per_s2", GRAVITY)
        gamma, section = density * gravity / (1.0 + self.void_ratio), self.parameter("silo", "section", "plane")
        return Janssen(width, height - self.transition_m, gamma, angle, pressure_ratio, section=section)

    @cached_property
    def silo(self) -> Silo:
        """The silo, its defaults where the run says nothing."""
        return Silo.model_validate(self.parameters.get("silo", {}))

    @property
    def free(self) -> bool:
        """Whether the sand falls out by its weight."""
        return self.parameter("flow", "outflow") == "gravity"

    @property
    def lopsided(self) -> bool:
        """Whether left and right wall are not alike."""
        left, right = self.silo.outlet_m
        return abs(left + right - self.silo.width_m) > 1e-9

    @property
    def transition_m(self) -> float:
        """Height of a hopper's upper end above its outlet [m]; 0 without."""
        return self.silo.transition_m

    @property
    def eurocode(self) -> EurocodeSilo | None:
        """The code's silo of this shape, or None if the run does not say enough, or the code no more."""
        if None in (self.parameter("silo", "width_m"), self.parameter("silo", "height_m")):
            return None
        code = eurocode_of(self.silo, self.wall_kind != "smooth")
        return None if code.slenderness == "retaining" else code

    def read_snapshot(self, file: str):
        """Return points (n, 2) [m], void ratio (n,) and side (n,) [m] of the square each point stands for."""
        path = self.folder / "snapshots" / Path(file).name  # no way out of the folder
        try:
            places, arrays = vtu.read(path)
        except Exception as error:  # noqa: BLE001 - whatever a broken file makes of a parser
            raise BadInput(f"snapshot {path} cannot be read; it is missing or damaged") from error
        void_ratio, volume = (arrays[name].astype(float) for name in ("void_ratio", "volume_m2_per_m"))
        finite = np.isfinite(places).all(axis=1) & np.isfinite(void_ratio) & (volume > 0.0)
        return places[finite, :2], void_ratio[finite], np.sqrt(volume[finite])


def _tables(path: Path, parse, trouble: list) -> dict:
    """Return the tables of a TOML or JSON file, or none if it is not there or damaged."""
    if not path.exists():
        return {}
    try:
        return parse(path)
    except BadInput:
        trouble.append(f"{path.name} is damaged and was left out.")
        return {}


def _table(path: Path, columns: tuple[str, ...], trouble: list) -> pd.DataFrame:
    """Return a table, or an empty one with these columns if the file is not there, has no content yet or is damaged.

    Numbers out of all bounds, which a run that went wrong may leave, words in place of numbers, and columns that are
    missing read as nan; without its first three columns a table is damaged.
    """
    empty = pd.DataFrame({name: pd.Series(dtype=object if name in WORDS else float) for name in columns})
    if not path.exists():
        return empty
    try:
        table = bounded_reading.frame(path)
        if not len(table.columns):
            return empty
        table[list(columns[:3])]
    except (BadInput, KeyError):
        trouble.append(f"{path.name} is damaged and was left out.")
        return empty
    table = table.reindex(columns=[*table.columns, *(name for name in columns if name not in table)])
    for name in table.columns.difference(WORDS):
        values = pd.to_numeric(table[name], errors="coerce")
        table[name] = values.where(values.abs() < 1e12)
    return table


def sand_title(run: RunFiles) -> str:
    """Return the name of a run's sand: loose or dense, with its initial void ratio."""
    return f"initially {'loose' if run.loose else 'dense'} sand ($e_0$ = {run.void_ratio:.2f})"


def by_void_ratio(runs) -> list[list[RunFiles]]:
    """Return the runs in groups of equal initial void ratio, densest first."""
    groups = {}
    for run in runs:
        groups.setdefault(round(run.void_ratio, 3) if np.isfinite(run.void_ratio) else 9.0, []).append(run)
    return [groups[void_ratio] for void_ratio in sorted(groups)]


def critical_simple_shear_angle_deg(critical_friction_angle_deg: float) -> float:
    """Return arctan(shear / normal stress) of the Gudehus-Bauer law in critical simple shear [degrees].

    All normal stresses are then equal, cos(3 theta) is 0 and the stress deviator's norm is x = a1, where
    1 / a1 = c1 + c2 x; the ratio is 3 x / sqrt(2). Values of c1 and c2: Bauer (1996).
    """
    law = GudehusBauer(critical_friction_angle_deg=critical_friction_angle_deg)
    c1, c2 = law.c1, law.c2
    x = (np.sqrt(c1**2 + 4.0 * c2) - c1) / (2.0 * c2)
    return float(np.degrees(np.arctan(3.0 * x / np.sqrt(2.0))))
