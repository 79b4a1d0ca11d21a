"""What of a sweep is drawn: a found quantity against what varied."""

from collections.abc import Iterable

from taichi_silo.errors import BadInput
from taichi_silo.studies.sweep.table import found
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options

PRESSURE = "largest_wall_normal_stress_pressure_cell_Pa"
NO_NUMBERS = ("flow_pattern",)


class Response(Options):
    """Columns of the sweep's table.

    Attributes
    ----------
    x : what varied, first in the figure; what varies first if absent.
    y : what was found.
    colour : what tells the points apart, varied or found; another that varied if absent.

    """

    x: str | None = None
    y: str = PRESSURE
    colour: str | None = None

    def check(self, columns: list[str]) -> None:
        """Refuse what the table of these varied columns does not hold.

        Raises
        ------
        BadInput
            with the name that was perhaps meant.

        """
        numbers = [name for name in found({}) if name not in NO_NUMBERS]
        _one_of("response.y", self.y, numbers)
        if self.x is not None:
            _one_of("response.x", self.x, columns)
        if self.colour is not None:
            _one_of("response.colour", self.colour, [*columns, *found({})])


def _one_of(name: str, value: str, known: Iterable[str]) -> None:
    known = list(known)
    if value not in known:
        meant = near(value, known, 0.4)
        right = f"did you mean {meant}?" if meant else f"it must be one of {', '.join(known)}"
        raise BadInput(f"{name} is {shown(value)}; {right}")
