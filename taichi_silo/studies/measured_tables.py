"""Tables of measurements as laboratories and spreadsheets leave them: text of any usual kind, with units in words."""

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import counted, shown

LARGEST, MOST_COLUMNS = 20_000_000, 100  # bytes of a file
REMARK = re.compile(r"^\s*(#|%|//)")  # begin of a line that is no row
BRACKETS = re.compile(r"^(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]$")
NO_VALUE = ("", "-", "--", "nan", "n/a", "na", "n.a.", "null", "none", "#n/a", "#nv", "#wert!", "#value!", "#div/0!")
SAYS = re.compile(r"[=:]")
AND = re.compile(r"[,;]\s+(?=[^\d\s])")  # between statements on one line
STATED = re.compile(r"^[\s#%/]*(.+?)\s*[=:;,\t ]\s*([-+−]?\d[\d.,]*(?:[eE][-+]?\d+)?)\s*[;,\t ]?\s*(\S*?)[;,\t ]*$")
THOUSANDS = re.compile(r"^[-+]?[1-9]\d{0,2}(,\d{3})+$")

Units = Mapping[str, float]
LENGTH: Units = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "inch": 0.0254, "ft": 0.3048}
STRESS: Units = {
    "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "psi": 6894.757, "psf": 47.88026, "bar": 1e5, "mbar": 100.0, "N/m2": 1.0,
    "N/m²": 1.0, "kN/m2": 1e3, "kN/m²": 1e3, "MN/m2": 1e6, "MN/m²": 1e6, "N/mm2": 1e6, "N/mm²": 1e6,
}  # fmt: skip


@dataclass(frozen=True)
class MeasuredTable:
    """What stands in a file: titles of columns with their units ("" if none is given), and rows of text."""

    file: Path
    heads: list[str]  # as they stand there
    names: list[str]  # without units
    units: list[str]
    rows: list[tuple[int, list[str]]]  # number of the line, cells
    remarks: list[str]  # lines that are no rows
    separator: str

    def line(self, number: int, column: int, cell: str) -> str:
        """Begin of the sentence that refuses a cell."""
        return f"{self.file}, line {number}: {self.heads[column]} is {shown(cell)}"

    def number(self, number: int, column: int, cell: str) -> float:
        """A cell as a number; nan where there is no value.

        Raises BadInput if it is none.
        """
        return value_of(cell, self.separator, self.line(number, column, cell))

    def stated(self) -> dict[str, tuple[float, str]]:
        """Numbers stated above the columns or in remarks ("cell pressure: 100 kPa, e0: 0.6"): value and unit."""
        found = {}
        several = (AND.split(remark) if len(SAYS.findall(remark)) > 1 else [remark] for remark in self.remarks)
        for remark in chain.from_iterable(several):
            if (match := STATED.match(remark)) and is_number(match[2]):
                name, number, unit = match.groups()
                found[name.strip(" =:;,\t")] = (value_of(number, ";", remark), unit.strip("[]()"))
        return found


def read_table(file: Path, units: Mapping[str, Units] | None = None, needed: str = "") -> MeasuredTable:
    """Read a file whose first row names the columns.

    The text may be UTF-8, UTF-16 or that of Windows. Columns are separated by commas, semicolons or tabs; with the
    latter two, or in quotes, numbers may have decimal commas. Lines that begin with #, % or // are remarks, and so is
    what stands above the columns.

    Parameters
    ----------
    file : its path.
    units : of every kind of quantity, by which the unit at the end of a title is known.
    needed : which columns it must have, in words.

    Raises
    ------
    BadInput
        if it cannot be read.

    """
    file = bounded_reading.place(file)
    numbered = enumerate(text_of(file).splitlines(), 1)
    lines = [(n, line) for n, line in numbered if line.strip(" ;,\t")]
    remarks = [line for _, line in lines if REMARK.match(line)]
    lines = [(n, line) for n, line in lines if not REMARK.match(line)]
    if not lines:
        raise BadInput(f"{file} is empty; its first line must name its columns{needed and f': {needed}'}")
    separator = max(
        ";\t,", key=lambda mark: sum(mark in line for _, line in lines[:20])
    )  # the first of the most frequent
    known = {unit.casefold(): unit for group in (units or {}).values() for unit in group}
    while len(lines) > 1 and _is_preamble(lines, separator, known):
        remarks.append(lines.pop(0)[1])
    if lines[0][1].count(separator) > MOST_COLUMNS:
        many = lines[0][1].count(separator) + 1
        raise BadInput(f"{file} has {many} columns; a table of measurements has at most {MOST_COLUMNS}")
    try:
        reader = csv.reader((line for _, line in lines), delimiter=separator)
        heads, *rows = [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        raise BadInput(f"{file} cannot be read as a table: {error}") from error
    heads = [" ".join(head.split()) for head in heads]  # spaces of all kinds are one
    while heads and not heads[-1]:  # what a spreadsheet leaves behind the last column
        heads.pop()
    if len(rows) != len(lines) - 1:
        raise BadInput(f"{file} has line breaks within quotes; it must have one row a line")
    names, found = zip(*(divided(head, known) for head in heads), strict=True)
    numbers = [number for number, _ in lines[1:]]
    if rows and not any(found) and (row := _units_row(rows[0], known)):
        found, rows, numbers = tuple(row[: len(heads)]), rows[1:], numbers[1:]
        heads = [f"{head} [{unit}]" if unit else head for head, unit in zip(heads, found, strict=False)]
    if not rows:
        raise BadInput(f"{file} has no rows; it must have at least one below the names of its columns")
    for number, row in zip(numbers, rows, strict=True):
        if len(row) < len(heads) or any(row[len(heads) :]):
            hint = "" if separator != "," else "; numbers with decimal commas need semicolons between columns"
            raise BadInput(f"{file}, line {number}, has {counted(len(row), 'value')}; it must have {len(heads)}{hint}")
    return MeasuredTable(
        file, heads, list(names), list(found), list(zip(numbers, rows, strict=True)), remarks, separator
    )


def text_of(file: Path) -> str:
    """The text of a file.

    Raises BadInput if it is no text.
    """
    data = bounded_reading.content(file, "a table", LARGEST)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = data.decode("utf-16", errors="replace")
        if any(sign.isascii() and sign.isalpha() for sign in text):
            return text
    if b"\x00" in data:
        raise BadInput(f"{file} cannot be read as a table: it must be text, in UTF-8 or UTF-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # as spreadsheets of Windows save it
        return data.decode("cp1252", errors="replace")


def divided(title: str, known: Mapping[str, str]) -> tuple[str, str]:
    """The name in a title and its unit, "" if none: strain [%], q (kPa), height_mm, stress, kPa."""
    if brackets := BRACKETS.match(title):
        return brackets[1], brackets[2]
    for key in sorted(known, key=len, reverse=True):
        head, end = title[: -len(key)], title[len(title) - len(key) :]
        apart = not key[0].isalnum() or head[-1:] in ("_", " ", ",", "/")
        if end.casefold() == key and apart and (bare := head.rstrip("_ ,/")):
            return bare, end
    return title, ""


def factor_of(unit: str, units: Units) -> float | None:
    """Factor of a unit to SI, in any spelling of letters that is not another one's; None if it is not of these."""
    if unit in units:
        return units[unit]
    alike = [factor for name, factor in units.items() if name.casefold() == unit.casefold()]
    return alike[0] if len(alike) == 1 else None


def value_of(cell: str, separator: str, where: str) -> float:
    """A number; nan where there is no value.

    Parameters
    ----------
    cell : as it stands in the file.
    separator : of the columns, which says whether a comma may part thousands.
    where : begin of the sentence that refuses it.

    Raises
    ------
    BadInput
        if it is no number.

    """
    text = cell.replace("−", "-").replace("–", "-").replace("\u00a0", "").replace("\u202f", "").strip()
    if text.casefold() in NO_VALUE:
        return math.nan
    if "," in text and "." in text:
        text = text.replace(",", "") if text.rfind(".") > text.rfind(",") else text.replace(".", "").replace(",", ".")
    elif text.count(",") > 1 and THOUSANDS.match(text):
        text = text.replace(",", "")
    elif separator == "," and THOUSANDS.match(text):
        raise BadInput(f"{where}; it must be written without a comma, as a thousand and as a fraction look alike")
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = math.inf
    if not math.isfinite(value):
        raise BadInput(f"{where}; it must be a number")
    return value


def is_number(cell: str) -> bool:
    """Whether a cell holds a number."""
    try:
        return math.isfinite(value_of(cell, ";", ""))
    except BadInput:
        return False


def _is_preamble(lines: list[tuple[int, str]], separator: str, known: Mapping[str, str]) -> bool:
    """Whether the first line stands above the columns.

    It is a title of one cell, a name with its value, or a line without units above another without numbers.
    """
    first, second, *rest = ([cell.strip(' "') for cell in line.split(separator)] for _, line in lines[:3])
    if len(first) > 1 and not is_number(first[0]) and is_number(first[1]):
        return True
    if not any(first[1:]) and sum(map(bool, second)) > 1:
        return True
    titled = not any(divided(cell, known)[1] for cell in first) and any(divided(cell, known)[1] for cell in second)
    return titled and not _units_row(second, known) and bool(rest) and is_number(rest[0][0])


def _units_row(row: list[str], known: Mapping[str, str]) -> list[str]:
    """The units in a row that holds nothing else; empty if it holds anything else."""
    bare = [cell.strip("[]() ") for cell in row]
    units = [cell if cell.casefold() in known else "" for cell in bare]
    nothing = [not cell or cell == "-" for cell in bare]
    return units if any(units) and all(u or n for u, n in zip(units, nothing, strict=True)) else []
