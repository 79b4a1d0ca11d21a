"""Latin hypercube: runs that vary everything at once, each quantity stratified over its whole range."""

import math
from decimal import Decimal
from typing import Any, TypeVar

import numpy as np
from pydantic import Field, ValidationError, field_validator, model_validator
from scipy.stats import qmc

from taichi_silo.errors import BadInput
from taichi_silo.studies.sweep.variations import MOST_RUNS
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options, one_sentence

Kind = TypeVar("Kind", bound=Options)
DIGITS = 6  # of values without a step, as many as the table shows


class Span(Options):
    """From `low` to `high`, both included; in steps from `low` on, such as whole cells, if a step is given."""

    low: float
    high: float
    step: float | None = Field(None, gt=0)
    logarithmic: bool = False

    @model_validator(mode="after")
    def _ordered(self):
        if not self.low < self.high:
            raise ValueError(f"low is {self.low:g}; it must be below high = {self.high:g}")
        if self.step is not None and self.step > self.high - self.low:
            raise ValueError(f"step is {self.step:g}; it must be at most high - low = {self.high - self.low:g}")
        if self.logarithmic and self.low <= 0.0:
            raise ValueError(f"low is {self.low:g}; it must be above 0 for a logarithmic span")
        return self

    def value(self, part: float, whole: bool) -> float | int:
        """At a part, from 0 to 1, of the way; every step (or whole number) has the same share of it."""
        step = self.step or (1.0 if whole else None)
        if step is None:
            return min(max(float(f"{self._between(part):.{DIGITS}g}"), self.low), self.high)
        last = math.floor((self.high - self.low) / step * (1.0 + 1e-12) + 1e-9)
        if self.logarithmic:
            number = min(round((self._between(part) - self.low) / step), last)
        else:
            number = min(int(part * (last + 1)), last)
        exact = Decimal(repr(self.low)) + number * Decimal(repr(step))
        return int(exact) if whole else float(exact)

    def _between(self, part: float) -> float:
        if self.logarithmic:
            return self.low * (self.high / self.low) ** part
        return self.low + part * (self.high - self.low)


class Choices(Options):
    """One of some values, each with the same share."""

    choices: tuple[Any, ...] = Field(min_length=2)

    def value(self, part: float, whole: bool) -> Any:
        """At a part, from 0 to 1, of the way through the list."""
        return self.choices[min(int(part * len(self.choices)), len(self.choices) - 1)]


class LatinHypercube(Options):
    """What varies between what, how often, and the seed of the draw."""

    runs: int = Field(ge=2, le=MOST_RUNS)
    seed: int = Field(1, ge=0)
    between: dict[str, Span | Choices] = Field(min_length=1, max_length=100)

    @field_validator("between", mode="before")
    @classmethod
    def _read(cls, given):
        return {path: _range(path, one) for path, one in given.items()} if isinstance(given, dict) else given

    def settings(self, whole=lambda path: False) -> list[dict]:
        """Values by their paths, once for each run; `whole` says whether those of a path are whole numbers."""
        # 0 to 1, each of `runs` equal parts of it once in each column
        drawn = qmc.LatinHypercube(d=len(self.between), seed=np.random.default_rng(self.seed)).random(self.runs)
        return [
            {path: one.value(part, whole(path)) for (path, one), part in zip(self.between.items(), row, strict=True)}
            for row in drawn.tolist()
        ]


def _range(path: str, given) -> Span | Choices:
    """Of [low, high], a list of words, or a table."""
    if isinstance(given, list):
        numbers = all(isinstance(one, int | float) and not isinstance(one, bool) for one in given)
        if not numbers:
            given = {"choices": given}
        elif len(given) == 2:
            given = dict(zip(("low", "high"), given, strict=True))
    if not isinstance(given, dict):
        right = "[low, high], a list of words, or a table of low, high or choices"
        raise ValueError(f"{shown(path)} is {shown(given)}; it must be {right}")
    return checked(Choices, given, f"{path}.") if "choices" in given else checked(Span, given, f"{path}.")


def checked(kind: type[Kind], given: dict, before: str = "") -> Kind:
    """Of what a file holds under the dotted name `before`.

    Raises BadInput if a name is unknown, with the one that was perhaps meant, or a value is not possible.
    """
    for name in given:
        if name not in kind.model_fields:
            meant = near(name, kind.model_fields, 0.5)
            words = f"did you mean {before}{meant}?" if meant else f"there are {', '.join(kind.model_fields)}"
            raise BadInput(f"{before}{shown(name)} is not a parameter of a sweep; {words}")
    try:
        return kind.model_validate(given)
    except ValidationError as error:
        begins_with_name = error.errors()[0]["type"] != "value_error"
        raise BadInput(f"{before if begins_with_name else ''}{one_sentence(error)}") from error
