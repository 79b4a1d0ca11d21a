"""The paper's statements on silo flow, `statements.toml`: typed, and checked when they are read."""

import tomllib
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Literal

from pydantic import Field, model_validator

from taichi_silo.utils.schema import Options
from validation.paper.cases import CASES

FILE = Path(__file__).with_name("statements.toml")
Kind = Literal["number", "relation", "figure", "not checkable here"]


class Term(Options):
    """A number that another one is divided by, or that is subtracted from it; what is not given is as in the other.

    Attributes
    ----------
    case : name of another case.
    swap : word of the case's name, and what stands in its place.
    measure, given : see `Test`.
    """

    case: str | None = None
    swap: tuple[str, str] | None = None
    measure: str | None = None
    given: dict[str, str | float] = {}

    def partner(self, case: str) -> str:
        """Name of the case that it is read from."""
        if self.swap is not None:
            return case.replace(*self.swap)
        return self.case or case


class Test(Options):
    """One number a case, and the range in which it agrees with the paper.

    Attributes
    ----------
    cases : names or patterns; those of the statement if not given.
    measure : name in `taichi_silo.paper.measures.MEASURES`.
    given : its arguments.
    over, minus : the number is divided by this term, or this term is taken from it.
    low, high : ends of the range, before the tolerance widens it.
    says : what the number is, in words.
    """

    __test__ = False  # no test class for pytest
    cases: tuple[str, ...] = ()
    measure: str
    given: dict[str, str | float] = {}
    over: Term | None = None
    minus: Term | None = None
    low: float | None = None
    high: float | None = None
    says: str = ""

    @model_validator(mode="after")
    def _range(self):
        if self.low is None and self.high is None:
            raise ValueError(f"a test of {self.measure} has neither low nor high; it must have one")
        return self

    @property
    def terms(self) -> tuple[Term, ...]:
        """The other sides."""
        return tuple(term for term in (self.over, self.minus) if term is not None)


class Tolerance(Options):
    """How far a number may lie outside the range and still agree (share of the range's end), and why."""

    share: float = Field(ge=0, lt=1)
    why: str


class Statement(Options):
    """One statement of the paper.

    Attributes
    ----------
    id, section : its name and place.
    kind : how it is checked.
    cases : names or patterns of the cases that it is about.
    states : it, in our words.
    paper : the number or relation, with units.
    tolerance : name of one in the file.
    tests : of numbers and relations.
    figure : which file of a run shows it, where only the eye can tell.
    seen : the eye's verdict, filled in by hand.
    reason : why it cannot be checked here; or why we disagree, where that is known: it then stands in the table.
    note : doubts about the text.
    """

    id: str
    section: Literal["6", "6.1", "6.2", "6.3", "7.1", "7.2", "8"]
    kind: Kind
    cases: tuple[str, ...]
    states: str
    paper: str
    tolerance: str = "none"
    tests: tuple[Test, ...] = ()
    figure: str = ""
    seen: Literal["", "yes", "no", "partly"] = ""
    reason: str = ""
    note: str = ""

    @model_validator(mode="after")
    def _whole(self):
        checked = self.kind in ("number", "relation")
        if checked != bool(self.tests):
            raise ValueError(f"statement {self.id} is a {self.kind} with {len(self.tests)} tests")
        if self.kind == "figure" and not self.figure:
            raise ValueError(f"statement {self.id} names no figure to look at")
        if self.kind == "not checkable here" and not self.reason:
            raise ValueError(f"statement {self.id} does not say why it cannot be checked")
        for case in named(self.cases):
            for test in self.tests:
                for term in test.terms:
                    for one in named(test.cases) or [case]:
                        if term.partner(one) not in CASES:
                            raise ValueError(f"statement {self.id} compares {one} with {term.partner(one)}: no case")
        return self

    def cases_of(self, test: Test) -> list[str]:
        """Names of the cases of one of its tests."""
        return named(test.cases or self.cases)

    @property
    def needs(self) -> list[str]:
        """Names of all runs that it takes."""
        found = dict.fromkeys(named(self.cases))
        for test in self.tests:
            for case in self.cases_of(test):
                found |= dict.fromkeys([case, *(term.partner(case) for term in test.terms)])
        return list(found)


def named(patterns: tuple[str, ...]) -> list[str]:
    """Cases that match any of the patterns, in the order of `CASES`; a pattern that none matches is refused."""
    for pattern in patterns:
        if not any(fnmatchcase(case, pattern) for case in CASES):
            raise ValueError(f"no case is called {pattern}")
    return [case for case in CASES if any(fnmatchcase(case, pattern) for pattern in patterns)]


def read(file: Path = FILE) -> tuple[list[Statement], dict[str, Tolerance]]:
    """Read all statements of a file, in its order, and its tolerances by name."""
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    tolerances = {name: Tolerance.model_validate(one) for name, one in content["tolerances"].items()}
    found = [Statement.model_validate(one) for one in content["statement"]]
    twice = {one.id for one in found if [other.id for other in found].count(one.id) > 1}
    if twice:
        raise ValueError(f"statements are there twice: {', '.join(sorted(twice))}")
    for one in found:
        if one.tolerance not in tolerances:
            raise ValueError(f"statement {one.id} has the tolerance {one.tolerance}, which the file does not explain")
    return found, tolerances
