"""One measured number of the stability map."""

import math
import operator
from dataclasses import dataclass

RELATIONS = {"<=": operator.le, ">=": operator.ge}


@dataclass(frozen=True)
class Cell:
    """A failure mode, a method, what was measured, and the bound within which the method holds."""

    mode: str
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

    def row(self) -> dict:
        """As in table.csv."""
        return {
            "mode": self.mode, "method": self.method, "measure": self.measure, "value": self.value, "unit": self.unit,
            "bound": f"{self.relation} {self.bound:g}", "holds": self.holds,
        }  # fmt: skip


def cells_of(mode: str, measure: str, unit: str, relation: str, bound: float, values: dict[str, float]) -> list[Cell]:
    """One cell for each method; a value that is no number is lost: infinite, on the side that does not hold."""
    lost = math.inf if relation == "<=" else -math.inf
    numbers = {method: lost if math.isnan(value) else float(value) for method, value in values.items()}
    return [Cell(mode, method, measure, value, unit, relation, bound) for method, value in numbers.items()]
