"""Any runs against what the paper states of their cases, which are recognised from their parameters.

A run that is none of the paper's flows says from which it differs, and in what. Relations between cases count where
runs of both are given. Runs nothing: seconds.
"""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Table
from typer import Argument, Option

from taichi_silo.cli import command_line
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import writable
from taichi_silo.studies.compare.whole import read_runs
from taichi_silo.utils import atomic_write
from validation.paper.check import count, judge
from validation.paper.files import CaseRun
from validation.paper.recheck import COLOURS
from validation.paper.recognise import Recognised, recognised
from validation.paper.statements import Statement, named, read

COLUMNS = ("run", "case", "id", "section", "kind", "statement", "paper", "ours", "agrees", "why")
NEVER = "not checkable here"


@dataclass(frozen=True)
class PaperFindings:
    """One run and the paper.

    Attributes
    ----------
    label : of the run.
    known : its case, and what is different.
    rows : the statements about it, `COLUMNS`.
    others : number of statements that compare it with cases of which no run was given.
    verdicts : how many statements have each verdict.

    """

    label: str
    known: Recognised
    rows: pd.DataFrame
    others: int
    verdicts: dict[str, int]


def against_paper(runs: list[Result]) -> list[PaperFindings]:
    """Each run against the statements on its case; of relations between cases, those of which both runs are given."""
    statements, tolerances = read()
    cases = {run.label: recognised(run.parameters) for run in runs}
    first = {}
    for run in runs:
        case = cases[run.label].case
        if case is not None:
            first.setdefault(case.name, CaseRun(run.folder, case))
    found = []
    for run in runs:
        known, rows, others = cases[run.label], [], 0
        if known.case is not None:
            here = first | {known.case.name: CaseRun(run.folder, known.case)}
            for statement in statements:
                if statement.kind == NEVER or not about(statement, known.case.name):
                    continue
                own = of_case(statement, known.case.name, set(here))
                if own is None:
                    others += 1
                    continue
                said = judge(own, tolerances[own.tolerance], here)
                words = (own.id, own.section, own.kind, own.states, own.paper)
                rows.append((run.label, known.case.name, *words, *said))
        table = pd.DataFrame(rows, columns=list(COLUMNS))
        found.append(PaperFindings(run.label, known, table, others, count(table)))
    return found


def of_case(statement: Statement, case: str, there: set[str]) -> Statement | None:
    """A statement as far as it is about one case, compared with none but those that are there; None if nothing is left.

    The reasons that it holds are those of other runs, and are left out.
    """
    tests = tuple(
        test.model_copy(update={"cases": (case,)})
        for test in statement.tests
        if case in statement.cases_of(test) and all(term.partner(case) in there for term in test.terms)
    )
    if bool(statement.tests) and not tests:
        return None
    return statement.model_copy(update={"cases": (case,), "tests": tests, "reason": "", "seen": ""})


def about(statement: Statement, case: str) -> bool:
    """Whether a statement says something of a case itself."""
    if statement.tests:
        return any(case in statement.cases_of(test) for test in statement.tests)
    return case in named(statement.cases)


def words(found: PaperFindings) -> list[str]:
    """Sentences that stand below the table of a run, or in its place if it is none of the paper's flows."""
    away = "; ".join(
        f"{path} {_given(mine)} instead of {_given(other)}" for path, mine, other in found.known.differences
    )
    if found.known.case is None:
        return [f"{found.label} is none of the paper's flows. From the nearest it differs in: {away}."]
    counted = ", ".join(f"{verdict} {number}" for verdict, number in found.verdicts.items() if number)
    lines = [f"{len(found.rows)} statements: {counted}."]
    if found.others:
        lines.append(f"{found.others} more compare it with other cases; give runs of those, too.")
    if away:
        lines.append(f"Computed otherwise than this project's runs of the paper: {away}.")
    return lines


def _given(value) -> str:
    return "none" if value in (None, [], ()) else str(value)


def against_runs(
    folders: Annotated[list[Path], Argument(metavar="DIR", help="runs of the paper's cases, of any name")],
    output: Annotated[Path, Option(help="folder of paper.csv, the table of all")] = Path("outputs") / "compare",
):
    """Set runs beside what the paper states of their cases."""
    found = against_paper(read_runs(folders))
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
    for one in found:
        if one.known.case is not None:
            title = f"{one.label}: the paper's {one.known.case.words}"
            table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
            for name, most in (("id", 22), ("statement", None), ("paper", None), ("this run", None), ("agrees", 8)):
                table.add_column(name, max_width=most, overflow="fold")
            for row in one.rows.itertuples():
                cells = (row.id, row.statement, row.paper, row.ours or row.why)
                escaped = [cell.replace("[", r"\[") for cell in cells]
                table.add_row(*escaped, row.agrees, style=COLOURS.get(row.agrees))
            console.print(table)
        console.print(*words(one), sep="\n")
    file = writable(output.expanduser()) / "paper.csv"
    with atomic_write.written(file) as passing:
        pd.concat([one.rows for one in found]).to_csv(passing, index=False, encoding="utf-8")
    print(file)


if __name__ == "__main__":
    command_line.command(against_runs)
