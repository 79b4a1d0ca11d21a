"""What is asked of a study of convergence: how small an error, of which numbers, for how much time."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from taichi_silo.errors import BadInput
from taichi_silo.studies.converge.estimate import Number
from taichi_silo.studies.converge.quantities import FORCES, NAMES, STATES
from taichi_silo.utils.messages import near, shown

HEADLINE = tuple(f"{force}_{state}" for state in STATES for force in FORCES)
SECONDS = {"s": 1.0, "sec": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0, "hours": 3600.0, "d": 86400.0}
LEAST, MOST = 1e-4, 1.0  # error that can be asked for
MOST_STEPS = 8  # of a ladder


@dataclass(frozen=True)
class Plan:
    """The error asked for, over the measure of each number; the numbers it is asked of; time by the clock; steps."""

    error: float = 0.02
    of: tuple[str, ...] = HEADLINE
    budget_s: float = 1200.0
    steps: int = MOST_STEPS

    def __post_init__(self):
        if not LEAST <= self.error <= MOST:
            raise BadInput(f"to is {shown(self.error)}; it must be between {LEAST:.2%} and {MOST:.0%}, such as 2%")
        if not self.budget_s > 0.0:
            raise BadInput(f"budget is {shown(self.budget_s)} s; it must be more, such as 20min")
        for name in self.of:
            if name not in NAMES:
                meant = near(name, NAMES)
                right = f"did you mean {meant}?" if meant else f"it must be one of {', '.join(NAMES)}"
                raise BadInput(f"of is {shown(name)}; {right}")
        if not 1 <= self.steps <= MOST_STEPS:
            raise BadInput(f"steps is {shown(self.steps)}; it must be between 1 and {MOST_STEPS}")

    def asked(self, numbers: Mapping[str, Number]) -> dict[str, Number]:
        """The numbers that the error is asked of.

        Raises BadInput if the scene has not one that is named.
        """
        for name in self.of:
            if name not in numbers and self.of != HEADLINE:
                raise BadInput(f"of is {name}; this scene has none, it must be one of {', '.join(numbers)}")
        return {name: numbers[name] for name in self.of if name in numbers}

    def worst(self, numbers: Mapping[str, Number]) -> tuple[str, Number] | None:
        """The number asked for with the largest error; None if there is none."""
        asked = self.asked(numbers)
        known = {name: one for name, one in asked.items() if one.relative == one.relative}
        if len(known) < len(asked):
            return None
        return max(known.items(), key=lambda item: item[1].relative, default=None)


def share(text: str | float) -> float:
    """An error as a number between 0 and 1, from 0.02 or "2%"; raises BadInput if it is none."""
    if isinstance(text, str):
        found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*(%?)\s*", text)
        try:
            return float(found[1]) / (100.0 if found[2] else 1.0) if found else _no_share(text)
        except ValueError:
            return _no_share(text)
    return float(text)


def seconds(text: str | float) -> float:
    """A time in seconds, from "20min", "1.5h", "90s" or a number of seconds; raises BadInput if it is none."""
    if isinstance(text, str):
        found = re.fullmatch(r"\s*([0-9.eE+-]+)\s*([a-z]*)\s*", text.lower())
        factor = SECONDS.get(found[2] or "s") if found else None
        try:
            return float(found[1]) * factor if found and factor else _no_time(text)
        except ValueError:
            return _no_time(text)
    return float(text)


def _no_share(text: str) -> float:
    raise BadInput(f"to is {shown(text)}; it must be an error such as 2% or 0.02")


def _no_time(text: str) -> float:
    raise BadInput(f"budget is {shown(text)}; it must be a time such as 20min, 1.5h or 90s")
