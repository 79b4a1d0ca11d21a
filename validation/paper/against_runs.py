"""Runs against what the paper states of their cases."""

from dataclasses import dataclass

import pandas as pd

from taichi_silo.show.figures.run_files import RunFiles
from validation.paper.check import count, judge
from validation.paper.files import RunFiles as PaperFiles
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


def against_paper(runs: list[RunFiles]) -> list[PaperFindings]:
    """Each run against the statements on its case; of relations between cases, those of which both runs are given."""
    statements, tolerances = read()
    cases = {run.label: recognised(run.parameters) for run in runs}
    first = {}
    for run in runs:
        case = cases[run.label].case
        if case is not None:
            first.setdefault(case.name, PaperFiles(run.folder, case))
    found = []
    for run in runs:
        known, rows, others = cases[run.label], [], 0
        if known.case is not None:
            here = first | {known.case.name: PaperFiles(run.folder, known.case)}
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
