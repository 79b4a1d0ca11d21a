"""Every statement of the paper against our runs: a verdict each, with both numbers, and the table of all."""

import math
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput
from validation.paper.cases import CASES
from validation.paper.measures import MEASURES, READINGS, CaseRun, NotRun
from validation.paper.statements import FILE, Statement, Test, Tolerance, read

VERDICTS = ("yes", "partly", "no", "by eye", "not run", "not checkable")
COLUMNS = ("id", "section", "kind", "statement", "paper", "ours", "agrees", "why")
UNITS = ("kPa", "mm", "deg")  # with which the words for a number may begin
FEW = 3  # of the numbers that disagree, named in the reason


@dataclass(frozen=True)
class Finding:
    """One number of one run, read one way, beside what it should be."""

    case: str
    reading: str
    says: str
    value: float
    low: float | None
    high: float | None

    @property
    def agrees(self) -> bool:
        """Whether it is in its range; a number that is not defined is not."""
        return (
            not math.isnan(self.value)
            and (self.low is None or self.value >= self.low)
            and (self.high is None or self.value <= self.high)
        )

    @property
    def wanted(self) -> str:
        """The range that it should lie in, widened by the tolerance, in words."""
        if self.low is None or self.high is None:
            return f"at most {self.high:.4g}" if self.low is None else f"at least {self.low:.4g}"
        return f"{self.low:.4g} to {self.high:.4g}" if self.low < self.high else f"{self.low:.4g}"


def evaluate(folder: Path, file: Path = FILE) -> pd.DataFrame:
    """The table of all statements: a row each, in the paper's order.

    Parameters
    ----------
    folder : holds the runs, each in a folder that is named as its case; what is missing reads "not run".
    file : the statements.

    Returns
    -------
    `COLUMNS`; agrees is one of `VERDICTS`, why says what disagrees or is missing.

    """
    statements, tolerances = read(file)
    runs = {name: CaseRun(Path(folder) / name, case) for name, case in CASES.items()}
    rows = []
    for one in statements:
        ours, agrees, why = judge(one, tolerances[one.tolerance], runs)
        row = (one.id, one.section, one.kind, one.states, one.paper, ours, agrees, why)
        rows.append(dict(zip(COLUMNS, row, strict=True)))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def judge(statement: Statement, tolerance: Tolerance, runs: dict[str, CaseRun]) -> tuple[str, str, str]:
    """Our numbers in words, the verdict, and why, of one statement."""
    if statement.kind == "not checkable here":
        return "", "not checkable", statement.reason
    trouble = _missing(statement, runs)
    if trouble:
        return "", "not run", trouble
    if statement.kind == "figure":
        if statement.seen:
            return f"seen in {statement.figure}", statement.seen, statement.reason
        first = statement.needs[0] if len(statement.needs) == 1 else "all its runs"
        return "", "by eye", f"look at {statement.figure} of {first}"
    try:
        found = [one for test in statement.tests for one in findings(statement, test, tolerance, runs)]
    except NotRun as error:
        return "", "not run", str(error)
    right = sum(one.agrees for one in found)
    agrees = "yes" if right == len(found) else "partly" if right else "no"
    return _words(found), agrees, "" if agrees == "yes" else statement.reason or _disagreement(found)


def findings(statement: Statement, test: Test, tolerance: Tolerance, runs: dict[str, CaseRun]) -> list[Finding]:
    """The numbers of one test: one a case and reading."""
    low = None if test.low is None else test.low - tolerance.share * abs(test.low)
    high = None if test.high is None else test.high + tolerance.share * abs(test.high)
    readings = ("",) if "reading" in test.given else READINGS.get(test.measure, ("",))
    return [
        Finding(case, reading, test.says or test.measure, _value(test, case, reading, runs), low, high)
        for case in statement.cases_of(test)
        for reading in readings
    ]


def _value(test: Test, case: str, reading: str, runs: dict[str, CaseRun]) -> float:
    """A test's number; nan where it is not defined."""
    value = _measure(runs[case], test.measure, test.given, reading)
    for term, divides in ((test.over, True), (test.minus, False)):
        if term is None:
            continue
        name = term.measure or test.measure
        given = term.given if term.measure else test.given | term.given
        other = _measure(runs[term.partner(case)], name, given, reading)
        if divides:
            value = value / other if other else math.nan
        else:
            value -= other
    return value


def _measure(run: CaseRun, name: str, given: dict, reading: str) -> float:
    """A measure of a run; whatever its broken files raise is said as damage."""
    words = given | ({"reading": reading} if reading and name in READINGS else {})
    try:
        return float(MEASURES[name](run, **words))
    except NotRun:
        raise
    except (ArithmeticError, KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise run.damaged(f"it gives no {name} ({error!r})") from error


def _missing(statement: Statement, runs: dict[str, CaseRun]) -> str:
    """Which runs of a statement are missing or damaged, in words."""
    said, failed = [], bool(statement.tests) and all(test.measure == "finished" for test in statement.tests)
    for name in statement.needs:
        try:
            runs[name].check(failed)
        except NotRun as error:
            said.append(str(error))
    if len(said) > FEW:
        return f"{said[0]}, and {len(said) - 1} more runs are missing"
    return "; ".join(said)


def _words(found: list[Finding]) -> str:
    """Numbers, gathered by what they are: a reading as a pressure cell stands in brackets."""
    gathered, names = {}, _short([one.case for one in found])
    for one in found:
        cells = gathered.setdefault(one.says, {}).setdefault(one.case, [])
        number = "none" if math.isnan(one.value) else f"{one.value:.3g}"
        cells.append(f"(cell {number})" if one.reading == "cell" else number)
    parts = []
    for says, cases in gathered.items():
        unit, says = _unit(says)
        words = {case: " ".join(cells) + unit for case, cells in cases.items()}
        numbers = [f"{word} [{names[case]}]" if len(names) > 1 else word for case, word in words.items()]
        parts.append(f"{says}: {', '.join(numbers)}" if says else ", ".join(numbers))
    return "; ".join(parts)


def _unit(says: str) -> tuple[str, str]:
    """Unit, with a space before it, and the rest of what a number is."""
    first, _, rest = says.partition(" ")
    return (f" {first.rstrip(',')}", rest) if first.rstrip(",") in UNITS else ("", says)


def _short(cases: list[str]) -> dict[str, str]:
    """Names of cases, less the outlet if all have the same."""
    same = len({case.rpartition("_")[2] for case in cases}) == 1 and len(set(cases)) > 1
    return {case: case.rpartition("_")[0] if same else case for case in cases}


def _disagreement(found: list[Finding]) -> str:
    """The first numbers that are out of range."""
    wrong, names, said = [one for one in found if not one.agrees], _short([one.case for one in found]), []
    for one in wrong[:FEW]:
        reading = " (as a cell reads)" if one.reading == "cell" else ""
        unit, says = _unit(one.says)
        value = "not defined" if math.isnan(one.value) else f"{one.value:.3g}{unit}"
        said.append(f"{names[one.case]}: {says + ' ' if says else ''}{value}{reading}, wanted {one.wanted}")
    if len(wrong) > FEW:
        said.append(f"{len(wrong) - FEW} more")
    return "; ".join(said)


def count(table: pd.DataFrame) -> dict[str, int]:
    """How many statements have each verdict."""
    return {verdict: int((table.agrees == verdict).sum()) for verdict in VERDICTS}


def markdown(table: pd.DataFrame) -> str:
    """The table for reading, a section each."""
    words = ", ".join(f"{verdict} {number}" for verdict, number in count(table).items())
    lines = ["# The paper's statements on silo flow, and our runs", "", f"{len(table)} statements: {words}."]
    lines += ["Numbers are those of nodes; in brackets, as a pressure cell of 20 mm reads them.", ""]
    for section, rows in table.groupby("section", sort=False):
        lines += [f"## Section {section}", "", "| id | statement | paper | ours | agrees | why |"]
        lines += ["|---|---|---|---|---|---|"]
        for row in rows.itertuples():
            cells = (row.id, row.statement, row.paper, row.ours, f"**{row.agrees}**", row.why)
            lines.append("| " + " | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in cells) + " |")
        lines.append("")
    return "\n".join(lines)


def write(table: pd.DataFrame, output: Path) -> list[Path]:
    """Leave `table.csv` and `table.md`, each in one piece or not at all; returns where they are."""
    output = Path(output)
    try:
        output.mkdir(parents=True, exist_ok=True)
        for name, text in (("table.csv", table.to_csv(index=False)), ("table.md", markdown(table))):
            temporary = output / f"{name}.part"
            temporary.write_text(text)
            temporary.replace(output / name)
    except OSError as error:
        raise BadInput(f"output {output} cannot be written: {error.strerror or error}") from error
    return [output / "table.csv", output / "table.md"]
