"""Named settings between cheap and accurate, `fidelity.toml`, with what the chart measured of each."""

import tomllib
from functools import cache
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.utils.schema import Options

FILE = Path(__file__).with_name("fidelity.toml")
STANDARD = "standard"  # the one whose values are the defaults of a scene


class Fidelity(Options):
    """Values at dotted paths of the scene; errors against the chart's reference, and its cost, if they were measured.

    The errors are those of `validation.accuracy.errors`, relative; the cost is that of the chart's scene
    [core-seconds].
    """

    settings: dict[str, float | int | str]
    error_P: float | None = None
    error_T: float | None = None
    error_N: float | None = None
    error_profile: float | None = None
    error_zone: float | None = None
    cost_core_seconds: float | None = None
    reference: str | None = None

    def words(self) -> str:
        """What was measured, in a sentence."""
        if self.error_N is None:
            return "its error has not been measured on this version (make chart does)"
        forces = ", ".join(f"{name} {100 * getattr(self, f'error_{name}'):.1f} %" for name in "PTN")
        return f"error {forces} against {self.reference}; {self.cost_core_seconds:.3g} core-seconds in the chart"


@cache
def fidelities(file: Path = FILE) -> dict[str, Fidelity]:
    """The named settings of a file."""
    tables = tomllib.loads(file.read_text(encoding="utf-8"))
    return {name: Fidelity.model_validate(table) for name, table in tables.items()}


def like(cell_size_m: float, speed_m_per_s: float) -> tuple[str, Fidelity] | None:
    """The named setting, if any, with these cells and this speed."""
    for name, one in fidelities().items():
        wanted = one.settings.get("grid.cell_size_m"), one.settings.get("flow.speed_m_per_s")
        if wanted == (cell_size_m, speed_m_per_s):
            return name, one
    return None


def fidelity(name: str) -> Fidelity:
    """The named setting of that name.

    Raises BadInput if there is none.
    """
    known = fidelities()
    if name not in known:
        raise BadInput(f"fidelity is {name}; it must be one of {', '.join(known)}")
    return known[name]
