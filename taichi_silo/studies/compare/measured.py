"""A user's measurements: a CSV file of curves or of a wall profile, its units read from the names of its columns."""

from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.show.report.words import mm
from taichi_silo.studies.measured_tables import LENGTH, STRESS, MeasuredTable, Units, factor_of, read_table
from taichi_silo.utils.messages import counted, near, shown

FORCE = {"N_per_m": 1.0, "kN_per_m": 1e3, "N/m": 1.0, "kN/m": 1e3}
OTHER = {"s": 1.0, "deg": 1.0}
PLACES: dict[str, Units] = {"displacement": LENGTH, "time": {"s": 1.0}}
CURVES = {  # column less its unit: what it is called here, its units
    "P": ("P", FORCE), "T": ("T", FORCE), "N": ("N", FORCE),
    "bottom_force": ("P", FORCE),
    "left_normal": ("left_normal", FORCE), "left_shear": ("left_shear", FORCE),
    "right_normal": ("right_normal", FORCE), "right_shear": ("right_shear", FORCE),
    "wall_friction_angle": ("angle", {"deg": 1.0}),
}  # fmt: skip
PROFILE = {"normal_stress": ("normal_stress_Pa", STRESS), "shear_stress": ("shear_stress_Pa", STRESS)}
KNOWN: dict[str, dict[str, tuple[str, Units]]] = {  # by kind of the file
    "curves": {name: (f"{name}_{next(iter(units))}", units) for name, units in PLACES.items()} | CURVES,
    "profile": {"height": ("height_m", LENGTH), "depth": ("depth_m", LENGTH)} | PROFILE,
}
PRESSING = {  # of what presses and cannot pull
    "normal_stress_Pa": "the normal stress [Pa]", "P": "P [N/m]", "N": "N [N/m]",
    "left_normal": "the left normal force [N/m]", "right_normal": "the right normal force [N/m]",
}  # fmt: skip
GERMAN = {
    "höhe": "height", "hoehe": "height", "tiefe": "depth", "weg": "displacement", "verschiebung": "displacement",
    "zeit": "time", "normalspannung": "normal_stress", "schubspannung": "shear_stress",
}  # fmt: skip
STATES = {"filling": "filling", "filled": "filling", "maximum": "maximum", "peak": "maximum", "residual": "residual"}
WALLS = ("left", "right", "both")
REMARKS = ("remark", "remarks", "comment", "comments", "note", "notes")  # columns that are passed over


@dataclass(frozen=True)
class Measured:
    """What was measured, in SI units.

    The table of curves has `displacement_m` or `time_s` (since the outflow began), rising, and any of P, T, N,
    left_normal, left_shear, right_normal, right_shear [N/m] and angle [degrees]; that of a profile height_m or depth_m,
    normal_stress_Pa or shear_stress_Pa, state ("filling", "maximum", "residual"; "" for any) and wall.
    """

    name: str  # of the file
    kind: str  # "curves" or "profile"
    table: pd.DataFrame
    notes: tuple[str, ...] = ()  # what was passed over, and how places are meant

    @property
    def place(self) -> str:
        """Name of the column that the quantities are measured against: height, depth, displacement or time."""
        names = ("height_m", "depth_m", "displacement_m", "time_s")
        return next(name for name in names if name in self.table)

    @property
    def quantities(self) -> list[str]:
        """Names of the columns of measured quantities."""
        return [name for name in self.table if name not in (self.place, "state", "wall")]

    @property
    def remarks(self) -> list[str]:
        """What is worth a word: what was passed over, and values of what presses that pull, compared as they are."""
        found = [f"{self.name}: {'; '.join(self.notes)}."] if self.notes else []
        for name in filter(self.quantities.__contains__, PRESSING):
            known = self.table[name].dropna()
            pulls = known[known < 0.0]
            if len(pulls):
                found.append(
                    f"{self.name}: {len(pulls)} of {counted(len(known), 'value')} of {PRESSING[name]} "
                    f"{are(len(pulls))} negative, the lowest {pulls.min():.4g}; pressures are "
                    "positive here, and these are compared as they are; is their sign right?"
                )
        return found

    def above_bottom(self, surface_m: float) -> "Measured":
        """The same with heights instead of depths below a surface at this height."""
        if "depth_m" not in self.table:
            return self
        table = self.table.rename(columns={"depth_m": "height_m"}).sort_values("height_m", ascending=False)
        table = table.assign(height_m=surface_m - table["height_m"]).reset_index(drop=True)
        level = f"depths are taken below the top of the fill, {mm(surface_m)} above the bottom"
        return replace(self, table=table, notes=(*self.notes, level))


def read(file: Path) -> Measured:
    """Read a file, see `measured_tables.read_table`; columns of remarks are passed over.

    Raises BadInput if it cannot be read, or a column or a value is not as it must be.
    """
    found = read_table(file, {"length": LENGTH, "force": FORCE, "stress": STRESS, "other": OTHER})
    kind, columns = _columns(found)
    table: dict[str, list] = {name: [] for name, _ in columns if name}
    for number, row in found.rows:
        for column, (cell, (name, factor)) in enumerate(zip(row, columns, strict=False)):
            if name and factor is None:
                table[name].append(_word(name, cell, found.line(number, column, cell)))
            elif name:
                table[name].append((factor or 0.0) * found.number(number, column, cell))
    left_out = [f"column {head} is passed over" for head, (name, _) in zip(found.heads, columns, strict=True)
                if head and not name]  # fmt: skip
    return _ordered(found.file, kind, pd.DataFrame(table), left_out)


def _columns(found: MeasuredTable) -> tuple[str, list[tuple[str, float | None]]]:
    """Kind of the file, and of each column its name here and its factor to SI; None for words."""
    file, head = found.file, found.heads
    columns = [_column(file, *one) for one in zip(found.heads, found.names, found.units, strict=True)]
    names, kinds = [name for _, name, _ in columns], {kind for kind, *_ in columns if kind}
    for name, title in zip(names, head, strict=True):
        if name and names.count(name) > 1:
            raise BadInput(f"{file} has {shown(title)} twice, under one name or another; it must be there once")
    if kinds == {"curves", "profile"}:
        raise BadInput(f"{file} has columns of curves and of a wall profile; it must have those of one of them")
    kind = kinds.pop() if kinds else "curves"
    needs = ("height_m", "depth_m") if kind == "profile" else ("displacement_m", "time_s")
    places, measured = [name for name in names if name in needs], set(names) - set(needs) - {"state", "wall", ""}
    if len(places) != 1 or not measured:
        raise BadInput(f"{file} has the columns {shown(', '.join(head))}; it must have {right_columns()}")
    return kind, [(name, factor) for _, name, factor in columns]


def _column(file: Path, title: str, name: str, unit: str) -> tuple[str, str, float | None]:
    """Kind, name and factor of a column."""
    key = title.casefold()
    if key in ("state", "wall"):
        return "profile", key, None
    if key in REMARKS:
        return "", "", None
    known_names = []
    bare = name.casefold().replace(" ", "_")
    bare = GERMAN.get(bare, bare)
    for kind, known in KNOWN.items():
        for start, (meant, units) in known.items():
            known_names += [f"{start}_{one}" for one in units if "/" not in one]
            if bare == start.casefold() and (factor := factor_of(unit, units)) is not None:
                return kind, meant, factor
    suggested = near(title, known_names, 0.5)
    if suggested:
        raise BadInput(f"{file} has the unknown column {shown(title)}; did you mean {suggested}?")
    unknown = shown(title) if title else "without a name"
    raise BadInput(f"{file} has the unknown column {unknown}; it must have {right_columns()}")


def are(number: int) -> str:
    """The verb of so many."""
    return "is" if number == 1 else "are"


def right_columns() -> str:
    """Which columns are right, in words."""
    forces = [name for name, (_, units) in CURVES.items() if units is FORCE]
    return (
        f"displacement_m or _mm, or time_s, with {', '.join(forces)} (in _N_per_m or _kN_per_m) or "
        "wall_friction_angle_deg; or height_m or depth_m with normal_ or shear_stress_kPa"
    )


def _word(name: str, cell: str, where: str) -> str:
    known = STATES if name == "state" else {wall: wall for wall in WALLS}
    if cell.casefold() not in known:
        raise BadInput(f"{where}; it must be one of {', '.join(known)}")
    return known[cell.casefold()]


def _ordered(file: Path, kind: str, table: pd.DataFrame, notes: list[str]) -> Measured:
    """The measurements sorted by place; several values at one place are replaced by their mean."""
    for name, usual in (("state", ""), ("wall", "both")) if kind == "profile" else ():
        if name not in table:
            table[name] = usual
    found = Measured(file.name, kind, table)
    if table[found.place].isna().any():
        raise BadInput(f"{file} has an empty {found.place}; it must be a number in every row")
    if table[found.quantities].isna().all(axis=None):
        raise BadInput(f"{file} has no values of {', '.join(found.quantities)}; it must have at least one")
    for name in found.quantities:
        if empty := int(table[name].isna().sum()):
            notes = [
                *notes,
                f"{empty} of {counted(len(table), 'row')} {'has' if empty == 1 else 'have'} no value of {name}",
            ]
    groups = [found.place, "state", "wall"] if kind == "profile" else [found.place]
    return Measured(file.name, kind, table.groupby(groups, as_index=False, sort=True).mean(), tuple(notes))
