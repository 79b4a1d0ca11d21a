"""A folder of laboratory tests: which test a file holds follows from its columns."""

from pathlib import Path

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.studies.calibrate.columns import UNITS, WORDS, quantity
from taichi_silo.studies.calibrate.lab_tests import IndexTests, Laboratory, Oedometer, Triaxial
from taichi_silo.studies.calibrate.plausible import (
    check_compression,
    check_index,
    check_oedometer,
    check_pore_pressure,
    check_triaxial,
)
from taichi_silo.studies.measured_tables import factor_of, read_table
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import counted, shown

SHEETS = (".xlsx", ".xls", ".ods", ".numbers")
ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc")
MOST_FILES = 200
LEAST_STRESS_Pa = 500.0  # below which a reading of an oedometer is one of the bare sample
KEPT = 0.1  # change of the cell pressure over itself
OTHERS = ("extension", "undrained", "undräniert")
INDEX = {
    "friction_angle": "friction_angle_deg", "e_min": "e_min", "e_max": "e_max",
    "grain_density": "grain_density_kg_per_m3", "d50": "d50_m",
}  # fmt: skip
RANGES = {  # of what is plausible, after the units
    "cell_pressure": (100.0, 1e8, "Pa"), "void_ratio": (0.05, 10.0, ""), "friction_angle": (10.0, 60.0, "deg"),
    "e_min": (0.05, 10.0, ""), "e_max": (0.05, 10.0, ""), "grain_density": (100.0, 2e4, "kg/m3"),
    "d50": (1e-7, 0.5, "m"), "strain": (0.0, 0.8, ""), "stress": (0.0, 1e9, "Pa"), "deviator": (1.0, 1e9, "Pa"),
    "densest": (100.0, 2e4, "kg/m3"), "loosest": (100.0, 2e4, "kg/m3"), "dry_density": (100.0, 2e4, "kg/m3"),
}  # fmt: skip
NEEDED = (
    "axial stress [kPa] with void ratio (oedometer), axial strain [%] with q [kPa] and the cell pressure (drained "
    "triaxial), angle of repose [deg], or e_min and e_max"
)


def read_laboratory(folder: Path) -> Laboratory:
    """All tests in the files of a folder, or in one file.

    Raises BadInput if there are none, or a file cannot be understood.
    """
    folder = bounded_reading.place(folder, "lab")
    if not folder.exists():
        raise BadInput(f"there is no folder {folder}; lab must be one with CSV files of laboratory tests")
    found = sorted(folder.iterdir()) if folder.is_dir() else [folder]
    files = [one for one in found if one.suffix.lower() in ENDINGS and not one.name.startswith(".")]
    if not files and not folder.is_dir():
        raise BadInput(
            f"lab {folder} is not a table: it must be a file {', '.join(ENDINGS)}, or a folder of such files"
        )
    if not files or len(files) > MOST_FILES:
        raise BadInput(
            f"lab {folder} has {counted(len(files), 'table')}; it must have 1 to {MOST_FILES} files "
            f"{', '.join(ENDINGS)}"
        )
    oedometers, triaxials, index = [], [], IndexTests()
    remarks = [f"{one.name} is passed over; save it as CSV" for one in found if one.suffix.lower() in SHEETS]
    read = [LabFile(file) for file in files]
    for one in read:
        one.add_index(index)
    densities = index.grain_density_kg_per_m3
    for one in read:
        if densities:
            one.grain_density = float(np.mean(densities))
        if one.has("axial_strain", "log_strain") and one.has("deviator", "axial_stress") and one.is_sheared():
            triaxials.append(one.triaxial())
        elif one.has("axial_stress") and one.has("void_ratio", "porosity", "axial_strain", "settlement", "log_strain"):
            oedometers.append(one.oedometer())
        elif not one.gives_index():
            raise BadInput(f"{one.file} has the columns {shown(', '.join(one.heads))}; it must have {NEEDED}")
        remarks += one.remarks
    check_index(folder, index)
    return Laboratory(oedometers, triaxials, index, remarks)


class LabFile:
    """One file: quantities in SI units by their names in `columns.WORDS`."""

    def __init__(self, file: Path):
        table = read_table(file, UNITS, NEEDED)
        self.file, self.heads, self.remarks = table.file, table.heads, list[str]()
        self._turned = 1.0  # -1 where compression is negative
        for word in OTHERS:
            if any(word in text.casefold() for text in (self.file.name, *table.remarks)):
                raise BadInput(f"{self.file} says that it is {word}; it must be a drained test in compression")
        self.columns: dict[str, np.ndarray] = {}
        self.stated: dict[str, float] = {}
        self.grain_density = 0.0
        passed = []
        for number, (head, name, unit) in enumerate(zip(table.heads, table.names, table.units, strict=True)):
            what = quantity(name) or quantity(head)
            if what == "pore_pressure" and unit and factor_of(unit, WORDS[what][0]) is None:
                what = None  # u is a displacement, too
            if what is None or what in self.columns:
                passed.append(head)
                continue
            cells = [table.number(line, number, row[number]) for line, row in table.rows]
            self.columns[what] = np.array(cells) * self._factor(what, head, unit)
            if what == "pore_pressure":
                passed.append(head)
        for name, (value, unit) in table.stated().items():
            if (what := quantity(name)) and what != "pore_pressure":
                self.stated[what] = value * self._factor(what, name, unit)
        if passed:
            self.remarks.append(f"{self.file.name}: passed over {shown(', '.join(passed))}")

    def _factor(self, what: str, title: str, unit: str) -> float:
        """Factor of a unit to SI; angles without a unit are degrees."""
        units = WORDS[what][0]
        factor = factor_of(unit or ("deg" if what == "friction_angle" else ""), units)
        if factor is None:
            right = ", ".join(name or "none" for name in list(units)[:6])
            given = f"the unit {shown(unit)}" if unit else "no unit"
            example = f"{title.split('[')[0].strip()} [{next(iter(units))}]"
            raise BadInput(f"{self.file}: {shown(title)} has {given}; it must be one of {right}, such as {example}")
        return factor

    def has(self, *names: str) -> bool:
        """Whether it has any of these columns."""
        return any(name in self.columns for name in names)

    def gives_index(self) -> bool:
        """Whether it holds an index test."""
        return any(name in self.columns or name in self.stated for name in (*INDEX, "densest", "loosest"))

    def is_sheared(self) -> bool:
        """Whether it is a triaxial test: a deviator, or a kept cell pressure beside the axial stress."""
        return "deviator" in self.columns or "cell_pressure" in self.stated or self._kept()

    def add_index(self, index: IndexTests) -> None:
        """Take over what it says of index tests."""
        for name, field in INDEX.items():
            getattr(index, field).extend(self._values(name))
        grains = self._values("grain_density") or index.grain_density_kg_per_m3
        for name, where in (("densest", index.e_min), ("loosest", index.e_max)):
            for density in self._values(name):
                if not grains:
                    raise BadInput(
                        f"{self.file} has densities but no grain density; it must have grain density [kg/m3] too"
                    )
                where.append(self._checked("void_ratio", grains[0] / density - 1.0))

    def _values(self, name: str, checked: bool = True) -> list[float]:
        """The values of a column, or the stated one; in their range if checked."""
        values = self.columns.get(name, np.array([self.stated[name]] if name in self.stated else []))
        found = [float(value) for value in values if np.isfinite(value)]
        return [self._checked(name, value) for value in found] if checked else found

    def _checked(self, name: str, value: float) -> float:
        low, high, unit = RANGES[name]
        if not low <= value <= high:
            raise BadInput(
                f"{self.file}: {name.replace('_', ' ')} is {value:g} {unit}".rstrip()
                + f"; it must be between {low:g} and {high:g}; is its unit right?"
            )
        return value

    def oedometer(self) -> Oedometer:
        """The oedometer test that it holds."""
        stress = self._compressive(self.columns["axial_stress"])
        e = self._void_ratio(self._strain() if not self.has("void_ratio", "porosity") else None)
        known = np.isfinite(stress) & np.isfinite(e) & (stress >= LEAST_STRESS_Pa)
        test = Oedometer(self.file.name, stress[known], e[known])
        self._enough(int(test.loading.sum()), "first loading")
        self._checked("stress", float(test.stress_Pa.max()))
        for value in test.void_ratio:
            self._checked("void_ratio", float(value))
        check_oedometer(self.file, test)
        return test

    def triaxial(self) -> Triaxial:
        """The triaxial test that it holds."""
        strain = self._strain()
        cell = self._cell()
        if "deviator" in self.columns:
            deviator = self._compressive(self.columns["deviator"])
        else:
            deviator = self._compressive(self.columns["axial_stress"]) - cell
        e = self._first_void_ratio()
        if self.has("volume_strain", "dilation"):
            turned = self.has("volume_strain")
            volume = self._turned * self.columns["volume_strain"] if turned else -self.columns["dilation"]
        elif self.has("void_ratio"):
            volume = (e - self.columns["void_ratio"]) / (1.0 + e)
        else:
            volume = np.full(len(strain), np.nan)
        check_pore_pressure(self.file, cell, np.array(self._values("pore_pressure", checked=False)))
        if self._turned < 0.0 and np.mean(self._values("cell_pressure", checked=False)) > 0.0:
            check_compression(self.file, cell, deviator)
        known = np.isfinite(strain) & (np.isfinite(deviator) | np.isfinite(volume))
        sure = not self.has("volume_strain")
        test = Triaxial(self.file.name, cell, e, strain[known], deviator[known], volume[known], sure)
        self._enough(int((test.loading & np.isfinite(test.deviator_Pa)).sum()), "first loading")
        self._checked("deviator", float(np.nanmax(test.deviator_Pa)))
        check_triaxial(self.file, test)
        return test

    def _strain(self) -> np.ndarray:
        """Axial logarithmic strain, compression positive."""
        if "settlement" in self.columns and not self.has("axial_strain", "log_strain"):
            height = self._one("first_height", "initial height [mm]")
            given = self.columns["settlement"] / height
        else:
            given = self.columns["log_strain" if "log_strain" in self.columns else "axial_strain"]
        known = given[np.isfinite(given)]
        if not len(known):
            raise BadInput(f"{self.file} has no values of the axial strain; it must have at least three")
        self._turned = -1.0 if abs(known.min()) > abs(known.max()) else 1.0
        strain = self._turned * given
        if self._turned < 0.0:
            self.remarks.append(f"{self.file.name}: compression is negative there")
        self._checked("strain", float(np.nanmax(strain)))
        return strain if "log_strain" in self.columns else -np.log1p(-strain)

    def _compressive(self, stress: np.ndarray) -> np.ndarray:
        """A stress, positive in compression, whichever sign it has in the file."""
        return -stress if np.nansum(stress) < 0.0 else stress

    def _void_ratio(self, strain: np.ndarray | None) -> np.ndarray:
        """Void ratio of an oedometer test, measured or from the strain."""
        if "void_ratio" in self.columns:
            return self.columns["void_ratio"]
        if "porosity" in self.columns:
            n = self.columns["porosity"]
            return n / (1.0 - n)
        assert strain is not None
        return (1.0 + self._first_void_ratio()) * np.exp(-strain) - 1.0

    def _cell(self) -> float:
        """The kept cell pressure [Pa], given, stated, or from mean stress and deviator."""
        if not self._values("cell_pressure", checked=False) and {"mean_stress", "deviator"} <= set(self.columns):
            p, q = (self._compressive(self.columns[name]) for name in ("mean_stress", "deviator"))
            self.columns["cell_pressure"] = p - q / 3.0
        value = self._one("cell_pressure", "cell pressure [kPa]")
        if self.has("cell_pressure") and not self._kept():
            raise BadInput(f"{self.file}: the cell pressure changes; it must be kept, as in a usual drained test")
        return self._checked("cell_pressure", abs(value))

    def _kept(self) -> bool:
        """Whether there is a column of the cell pressure, and it hardly changes."""
        values = np.abs(self._values("cell_pressure", checked=False)) if self.has("cell_pressure") else np.array([])
        return len(values) > 0 and bool(np.ptp(values) <= KEPT * values.mean())

    def _first_void_ratio(self) -> float:
        """Void ratio at the begin: given, stated, from the dry density, or the first of the column."""
        if density := self._values("dry_density"):
            if not self.grain_density:
                raise BadInput(
                    f"{self.file} has a dry density but no grain density; it must have grain density [kg/m3]"
                )
            return self._checked("void_ratio", self.grain_density / density[0] - 1.0)
        for name in ("first_void_ratio", "void_ratio"):
            if values := self._values(name, checked=False):
                return self._checked("void_ratio", values[0])
        return self._one("first_void_ratio", "e0 (initial void ratio)")

    def _one(self, name: str, words: str) -> float:
        """The mean of what should be one value, in a column or stated above the columns."""
        values = self._values(name, checked=False)
        if not values:
            bare, _, unit = words.partition(" [")
            example = f"# {bare.split(' (')[0]} = {'100 ' + unit.rstrip(']') if unit else 0.65}"
            raise BadInput(f"{self.file} has no {words}; give a column, or a line such as {example}")
        return float(np.mean(values))

    def _enough(self, count: int, words: str) -> None:
        if count < 3:
            points = counted(count, "point")
            raise BadInput(f"{self.file} has {points} of {words}; it must have at least 3")
