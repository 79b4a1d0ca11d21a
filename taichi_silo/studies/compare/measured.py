"""A user's measurements: a CSV file of curves or of a wall profile, its units read from the names of its columns."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import near, shown

LENGTH = {"m": 1.0, "mm": 1e-3}
FORCE = {"N_per_m": 1.0, "kN_per_m": 1e3}
STRESS = {"Pa": 1.0, "kPa": 1e3}
PLACES = {"displacement": LENGTH, "time": {"s": 1.0}}
CURVES = {  # column less its unit: what it is called here, its units
    "P": ("P", FORCE), "T": ("T", FORCE), "N": ("N", FORCE),
    "bottom_force": ("P", FORCE),
    "left_normal": ("left_normal", FORCE), "left_shear": ("left_shear", FORCE),
    "right_normal": ("right_normal", FORCE), "right_shear": ("right_shear", FORCE),
    "wall_friction_angle": ("angle", {"deg": 1.0}),
}  # fmt: skip
PROFILE = {"normal_stress": ("normal_stress_Pa", STRESS), "shear_stress": ("shear_stress_Pa", STRESS)}
LARGEST, MOST_COLUMNS = 20_000_000, 100  # bytes of a file
STATES = {"filling": "filling", "filled": "filling", "maximum": "maximum", "peak": "maximum", "residual": "residual"}
WALLS = ("left", "right", "both")
REMARKS = ("remark", "remarks", "comment", "comments", "note", "notes")  # columns that are passed over


@dataclass(frozen=True)
class Measured:
    """What was measured, in SI units.

    The table of curves has `displacement_m` or `time_s` (since the outflow began), rising, and any of P, T, N,
    left_normal, left_shear, right_normal, right_shear [N/m] and angle [degrees]; that of a profile height_m,
    normal_stress_Pa or shear_stress_Pa, state ("filling", "maximum", "residual"; "" for any) and wall.
    """

    name: str  # of the file
    kind: str  # "curves" or "profile"
    table: pd.DataFrame

    @property
    def place(self) -> str:
        """Name of the column that the quantities are measured against: height, displacement or time."""
        names = ("height_m", "displacement_m", "time_s")
        return next(name for name in names if name in self.table)

    @property
    def quantities(self) -> list[str]:
        """Names of the columns of measured quantities."""
        return [name for name in self.table if name not in (self.place, "state", "wall")]


def read(file: Path) -> Measured:
    """Read a file; separators are commas, or semicolons or tabs, with which numbers may have decimal commas.

    Lines that begin with # and columns of remarks are passed over.

    Raises BadInput if it cannot be read, or a column or a value is not as it must be.
    """
    file = bounded_reading.place(file)
    text = bounded_reading.content(file, "a table", LARGEST)
    if b"\x00" in text:
        raise BadInput(f"{file} cannot be read as a table: it must be text, in UTF-8")
    try:
        whole = text.decode("utf-8-sig")
    except UnicodeDecodeError:  # as spreadsheets of Windows save it
        whole = text.decode("cp1252", errors="replace")
    numbered = enumerate(whole.splitlines(), 1)
    lines = [(n, line) for n, line in numbered if line.strip(" ;,\t") and not line.startswith("#")]
    if not lines:
        raise BadInput(f"{file} is empty; its first line must name its columns")
    separator = next((mark for mark in (";", "\t") if mark in lines[0][1]), ",")
    if lines[0][1].count(separator) > MOST_COLUMNS:
        many = lines[0][1].count(separator) + 1
        raise BadInput(f"{file} has {many} columns; a table of measurements has at most {MOST_COLUMNS}")
    try:
        reader = csv.reader((line for _, line in lines), delimiter=separator)
        head, *rows = [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        raise BadInput(f"{file} cannot be read as a table: {error}") from error
    while head and not head[-1]:  # what a spreadsheet leaves behind the last column
        head.pop()
    kind, columns = _columns(file, head)
    if not rows:
        raise BadInput(f"{file} has no rows; it must have at least one below the names of its columns")
    if len(rows) != len(lines) - 1:
        raise BadInput(f"{file} has line breaks within quotes; it must have one row a line")
    table: dict[str, list] = {name: [] for name, _ in columns if name}
    for (number, _), row in zip(lines[1:], rows, strict=True):
        if len(row) < len(head) or any(row[len(head) :]):
            hint = "" if separator != "," else "; numbers with decimal commas need semicolons between columns"
            raise BadInput(f"{file}, line {number}, has {len(row)} values; it must have {len(head)}{hint}")
        for cell, title, (name, factor) in zip(row, head, columns, strict=False):
            if not name:
                continue
            where = f"{file}, line {number}: {title} is {shown(cell)}"
            table[name].append(_word(name, cell, where) if factor is None else factor * _value(cell, where, separator))
    return _ordered(file, kind, pd.DataFrame(table))


def _columns(file: Path, head: list[str]) -> tuple[str, list[tuple[str, float | None]]]:
    """Kind of the file, and of each column its name here and its factor to SI; None for words."""
    found = [_column(file, title) for title in head]
    names, kinds = [name for _, name, _ in found], {kind for kind, *_ in found if kind}
    for name, title in zip(names, head, strict=True):
        if name and names.count(name) > 1:
            raise BadInput(f"{file} has {shown(title)} twice, under one name or another; it must be there once")
    if kinds == {"curves", "profile"}:
        raise BadInput(f"{file} has columns of curves and of a wall profile; it must have those of one of them")
    kind = kinds.pop() if kinds else "curves"
    needs = ("height_m",) if kind == "profile" else ("displacement_m", "time_s")
    places, measured = [name for name in names if name in needs], set(names) - set(needs) - {"state", "wall", ""}
    if len(places) != 1 or not measured:
        raise BadInput(f"{file} has the columns {shown(', '.join(head))}; it must have {right_columns()}")
    return kind, [(name, factor) for _, name, factor in found]


def _column(file: Path, title: str) -> tuple[str, str, float | None]:
    """Kind, name and factor of a column."""
    key = title.casefold()
    if key in ("state", "wall"):
        return "profile", key, None
    if key in REMARKS:
        return "", "", None
    known_names = []
    for kind, known in (
        ("curves", {name: (f"{name}_{next(iter(units))}", units) for name, units in PLACES.items()}),
        ("curves", CURVES),
        ("profile", {"height": ("height_m", LENGTH)} | PROFILE),
    ):
        for start, (name, units) in known.items():
            for unit, factor in units.items():
                known_names.append(f"{start}_{unit}")
                if key == f"{start}_{unit}".casefold():
                    return kind, name, factor
    meant = near(title, known_names, 0.5)
    if meant:
        raise BadInput(f"{file} has the unknown column {shown(title)}; did you mean {meant}?")
    unknown = shown(title) if title else "without a name"
    raise BadInput(f"{file} has the unknown column {unknown}; it must have {right_columns()}")


def right_columns() -> str:
    """Which columns are right, in words."""
    forces = [name for name, (_, units) in CURVES.items() if units is FORCE]
    return (
        f"displacement_m or _mm, or time_s, with {', '.join(forces)} (in _N_per_m or _kN_per_m) or "
        "wall_friction_angle_deg; or height_m with normal_ or shear_stress_kPa"
    )


def _value(cell: str, where: str, separator: str) -> float:
    """A number; nan where there is none."""
    if not cell:
        return math.nan
    try:
        value = float(cell.replace(",", ".") if separator != "," else cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise BadInput(f"{where}; it must be a number")
    return value


def _word(name: str, cell: str, where: str) -> str:
    known = STATES if name == "state" else {wall: wall for wall in WALLS}
    if cell.casefold() not in known:
        raise BadInput(f"{where}; it must be one of {', '.join(known)}")
    return known[cell.casefold()]


def _ordered(file: Path, kind: str, table: pd.DataFrame) -> Measured:
    """The measurements sorted by place; several values at one place are replaced by their mean."""
    for name, usual in (("state", ""), ("wall", "both")) if kind == "profile" else ():
        if name not in table:
            table[name] = usual
    found = Measured(file.name, kind, table)
    if table[found.place].isna().any():
        raise BadInput(f"{file} has an empty {found.place}; it must be a number in every row")
    groups = [found.place, "state", "wall"] if kind == "profile" else [found.place]
    return Measured(file.name, kind, table.groupby(groups, as_index=False, sort=True).mean())
