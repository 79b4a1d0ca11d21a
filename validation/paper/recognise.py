"""Which of the paper's flows a run is, from its parameters, and what was computed otherwise than in the 17 runs."""

from dataclasses import dataclass

from taichi_silo.runs.run_folder import parameters
from validation.paper.cases import CASES, Case
from validation.paper.scenes import scene_of

SAME = ("silo", "sand", "walls", "flow.outflow")  # what makes a case
APART = ("silo.half", "sand.name", "sand.law", "sand.intergranular", "walls.bottom_friction_angle_deg")
OTHERS = ("walls.bottom_friction_angle_deg", "sand.law", "grid", "averaging", "filling.kind", "flow", "method")
CLOSE = 1e-6  # relative, of numbers


@dataclass(frozen=True)
class Recognised:
    """A run and the paper's flows.

    Attributes
    ----------
    case : which it is; None if it is none of them.
    differences : of one that is none, from the nearest case: dotted path, its value, the case's; of another, how it
        was computed otherwise than the paper's 17 flows of this project.

    """

    case: Case | None
    differences: tuple[tuple[str, object, object], ...]


def recognised(tables: dict) -> Recognised:
    """The case of a `run.toml`."""
    own, best = flat(tables), None
    for case in CASES.values():
        wanted = flat(parameters(scene_of(case)))
        away = [one for one in _differences(own, wanted, SAME) if not _within(one[0], APART)]
        if not away:
            return Recognised(case, tuple(_otherwise(own, wanted, case)))
        if best is None or len(away) < len(best):
            best = away
    return Recognised(None, tuple(best))


def flat(tables: dict, path: str = "") -> dict[str, object]:
    """Values by dotted path."""
    found = {}
    for name, value in tables.items():
        here = f"{path}.{name}" if path else name
        found |= flat(value, here) if isinstance(value, dict) else {here: value}
    return found


def _otherwise(own: dict, wanted: dict, case: Case):
    without = ("flow.longest_s", *(("flow.speed_m_per_s", "flow.displacement_m") if case.gravity else ()))
    for one in _differences(own, wanted, OTHERS):
        if not _within(one[0], without):
            yield one


def _differences(own: dict, wanted: dict, paths: tuple[str, ...]):
    for path in sorted(own.keys() | wanted.keys()):
        if _within(path, paths):
            mine, other = own.get(path), wanted.get(path)
            if not _equal(mine, other):
                yield path, mine, other


def _within(path: str, paths: tuple[str, ...]) -> bool:
    return any(path == one or path.startswith(f"{one}.") for one in paths)


def _equal(one, other) -> bool:
    numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in (one, other))
    if numbers:
        return abs(one - other) <= CLOSE * max(abs(one), abs(other))
    empty = ([], (), None)
    return one == other or (one in empty and other in empty)
