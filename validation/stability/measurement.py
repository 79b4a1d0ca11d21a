"""One measured number of the stability map, a cell of its tables."""

import math
import operator
from dataclasses import dataclass

RELATIONS = {"<=": operator.le, ">=": operator.ge}


@dataclass(frozen=True)
class Measurement:
    """A method, what was measured of it, and the bound within which the method holds."""

    method: str
    measure: str
    value: float
    unit: str
    relation: str  # "<=" or ">="
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the number lies within its bound; a number that is none never does."""
        return bool(RELATIONS[self.relation](self.value, self.bound))

    def row(self, failure_mode: str) -> dict:
        """The row of table.csv."""
        return {
            "mode": failure_mode, "method": self.method, "measure": self.measure, "value": self.value,
            "unit": self.unit, "bound": f"{self.relation} {self.bound:g}", "holds": self.holds,
        }  # fmt: skip


def measurements(measure: str, unit: str, relation: str, bound: float, values: dict[str, float]) -> list[Measurement]:
    """One measurement for each method; nan counts as lost: infinite, on the side that does not hold."""
    lost = math.inf if relation == "<=" else -math.inf
    numbers = {method: lost if math.isnan(value) else float(value) for method, value in values.items()}
    return [Measurement(method, measure, value, unit, relation, bound) for method, value in numbers.items()]
