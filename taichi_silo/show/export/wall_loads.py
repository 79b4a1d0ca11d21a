"""Pressures on walls for shell programs: of EN 1991-4's load cases, or of a run's three states.

A load is a field of pressure and friction over height and angle. All lengths are in m, stresses in Pa. z is the height
above the foot of the vertical walls (of a hopper: above its outlet), upwards. The angle runs round the axis from the x
axis, which points to the outlet's side, or to the right wall of a plane silo: 0 is the right wall, 180 the left one.
Pressure is outward positive, on the inner face; friction is downward positive, the traction of the solid on the wall.
"""

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from taichi_silo.analysis.theory.eurocode.load_cases import LoadCase
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.analysis.theory.walker import WalkerHopper
from taichi_silo.runs.result import Result
from taichi_silo.show.export import abaqus
from taichi_silo.show.report.eurocode import EurocodeReport

STATES = ("filling", "maximum", "residual")  # of walls.csv
STEP_DEG = 15.0
ROWS = 41  # of the tables, from foot to top

Field = Callable[[NDArray, float], NDArray]  # of heights [m] and an angle [deg]


@dataclass(frozen=True)
class WallLoad:
    """Pressure and friction on one wall in one load case."""

    case: str
    about: str  # where it comes from
    wall: str  # "wall", or "hopper"
    normal_Pa: Field
    shear_Pa: Field
    height_m: float  # of the wall
    foot_width_m: float  # of the silo at the wall's foot: diameter, or distance of two walls
    top_width_m: float
    section: str  # "round" or "plane"
    length_m: float | None  # of a rectangular silo along y; None: per metre run
    cuts_m: tuple[float, ...] = ()  # heights at which it jumps
    turns_deg: tuple[float, ...] = ()  # angles at which it jumps
    symmetrical: bool = True

    @property
    def angles_deg(self) -> NDArray:
        """Angles of its points: all walls of a plane silo, every 15 degrees of a round one."""
        if self.section == "plane":
            return np.array([0.0, 180.0] if self.length_m is None else [0.0, 90.0, 180.0, 270.0])
        return np.arange(0.0, 360.0, STEP_DEG)

    def width_m(self, height_m: NDArray) -> NDArray:
        """Width of the silo at heights."""
        share = np.asarray(height_m) / self.height_m
        return self.foot_width_m + share * (self.top_width_m - self.foot_width_m)

    def table(self) -> pd.DataFrame:
        """Values at points: case, wall, height, depth, angle, place, pressure and friction."""
        z = np.linspace(0.0, self.height_m, ROWS)
        half, rows = 0.5 * self.width_m(z), []
        for angle in self.angles_deg:
            x, y = np.cos(np.radians(angle)) * half, np.sin(np.radians(angle)) * half
            if self.length_m is not None and angle in (90.0, 270.0):
                x, y = 0.0 * half, np.sign(y) * 0.5 * self.length_m
            rows.append(pd.DataFrame({
                "case": self.case, "wall": self.wall, "depth_m": self.height_m - z, "height_m": z, "angle_deg": angle,
                "x_m": np.round(x, 12), "y_m": np.round(y, 12),
                "normal_Pa": self.normal_Pa(z, float(angle)), "shear_Pa": self.shear_Pa(z, float(angle)),
            }))  # fmt: skip
        return pd.concat(rows, ignore_index=True)


def of_code(report: EurocodeReport) -> list[WallLoad]:
    """The load cases of EN 1991-4, those on a hopper as well."""
    silo, found = report.silo, []

    def turned(one: LoadCase) -> WallLoad:
        return WallLoad(
            one.name, f"clause {one.clause}", "wall",
            lambda z, angle: one.normal_Pa(_down(silo.height_m, z), angle),
            lambda z, angle: one.shear_Pa(_down(silo.height_m, z), angle),
            silo.height_m, silo.width_m, silo.width_m, silo.section, silo.length_m,
            tuple(silo.height_m - cut for cut in (*one.cuts_m, silo.surface_depth_m) if 0.0 < cut < silo.height_m),
            one.turns_deg, one.symmetrical,
        )  # fmt: skip

    found += [turned(one) for one in report.cases]
    if report.hopper_rows and report.bottom is not None:
        hoppers = {state: report.bottom.hopper(state) for state in ("filling", "discharge")}
        found += [_hopper(f"hopper_{state}", one, silo) for state, one in hoppers.items() if one is not None]
    return found


def _hopper(case: str, hopper: WalkerHopper, silo: EurocodeSilo) -> WallLoad:
    """The load on a hopper's wall."""
    low, high = hopper.outlet_height_m, hopper.transition_height_m

    def above_apex(z: NDArray) -> NDArray:
        return np.clip(low + np.asarray(z), low, high)

    return WallLoad(
        case, "clauses 6.3, 6.4", "hopper",
        lambda z, _: hopper.normal_stress_Pa(above_apex(z)), lambda z, _: hopper.shear_stress_Pa(above_apex(z)),
        high - low, hopper.outlet_m, hopper.width_m, silo.section, silo.length_m,
    )  # fmt: skip


def _down(height_m: float, z: NDArray) -> NDArray:
    """Depths of heights; those of rounding within the wall."""
    return np.clip(height_m - np.asarray(z), 0.0, height_m)


def of_run(run: Result) -> list[WallLoad]:
    """Wall stresses of a run after filling, where N is largest in flow, and at its end.

    In a round silo both sides of the section are one wall, and the mean of both counts. One side of a hopper
    stands for both where the run left no other.
    """
    silo, found = run.scene.silo, []
    low, high = silo.transition_m, silo.height_m
    hopper = 0.0 if silo.hopper is None else silo.hopper.outlet_width_m
    for state in STATES:
        for wall, names, foot, top, width in (
            ("wall", ("right", "left"), low, high, silo.width_m),
            ("hopper", ("hopper_right", "hopper_left"), 0.0, low, hopper),
        ):
            if wall == "hopper" and silo.hopper is None:
                continue
            normal, shear = (
                [one for name in names if len((one := run.profile(state, name, quantity))[0]) > 1]
                for quantity in ("normal_stress_Pa", "shear_stress_Pa")
            )
            if not (normal and shear and top > foot):
                continue
            found.append(WallLoad(
                f"{wall}_{state}" if wall == "hopper" else state, "simulated", wall,
                _sides(normal, foot, silo.section), _sides(shear, foot, silo.section), top - foot, width,
                silo.width_m, silo.section, None, (), (90.0, 270.0), silo.section == "round",
            ))  # fmt: skip
    return found


def _sides(profiles: list[tuple[NDArray, NDArray]], foot_m: float, section: str) -> Field:
    """A field from the profiles (heights, stresses) of the right and the left wall, or of one for both."""

    def at(z: NDArray, angle_deg: float) -> NDArray:
        right, left = (np.interp(foot_m + np.asarray(z), *profiles[end]) for end in (0, -1))
        if section == "round":
            return 0.5 * (right + left)
        return left if 90.0 < angle_deg < 270.0 else right

    return at


def write(run: Result, target: Path, seen: Callable[[], None] = lambda: None) -> int:
    """Write the wall loads of a run into a folder; returns how many states of walls there are."""
    loads = of_run(run)
    write_loads(loads, target, f"run {run.label}")
    seen()
    return len({one.case.removeprefix("hopper_") for one in loads})


def write_loads(loads: list[WallLoad], target: Path, about: str) -> None:
    """Write loads into a folder, which is there when all are complete, or not at all; an earlier one is replaced.

    `wall_pressures.csv`: all points of all cases. `points_CASE.txt`: X, Y, Z, pressure P and friction T of one case,
    for mapped fields. `CASE.inp`, `CASE_elements.inp` and `surfaces.csv`: see `abaqus`.
    """
    passing = target.absolute().with_name(f"{target.name}.part")
    shutil.rmtree(passing, ignore_errors=True)
    passing.mkdir(parents=True)
    try:
        tables = [one.table() for one in loads]
        every = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
        every.to_csv(passing / "wall_pressures.csv", index=False, float_format="%.8g")
        surfaces = []
        for one, table in zip(loads, tables, strict=True):
            columns = {"x_m": "X", "y_m": "Y", "height_m": "Z", "normal_Pa": "P", "shear_Pa": "T"}
            table[list(columns)].rename(columns=columns).to_csv(
                passing / f"points_{one.case}.txt", index=False, sep=" ", float_format="%.8g"
            )
            texts, names = abaqus.include_files(one, about)
            for end, text in texts.items():
                (passing / f"{one.case}{end}.inp").write_text(text, encoding="utf-8")
            surfaces += names
        pd.DataFrame(surfaces).drop_duplicates().to_csv(passing / "surfaces.csv", index=False, float_format="%.8g")
        shutil.rmtree(target, ignore_errors=True)
        passing.rename(target)
    finally:
        shutil.rmtree(passing, ignore_errors=True)
