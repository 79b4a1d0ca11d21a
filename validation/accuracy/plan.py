"""Which runs a chart needs: every setting of every dial about the base, and the reference of each pair of walls."""

from dataclasses import dataclass

from taichi_silo.cli.model_silo import SMOOTH_ANGLE_DEG
from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Scene
from validation.accuracy.points import Point, point
from validation.accuracy.varied_settings import Program, listed, words

REFERENCE, ROUNDING = "reference", "rounding"


@dataclass(frozen=True)
class Entry:
    """A setting of a dial: the walls, the dial, the setting in words, what it is for, the run, and what was set."""

    walls: str
    dial: str
    setting: str
    purpose: str
    point: Point
    paths: tuple[str, ...]


WALLS = {  # of dense sand
    "very-rough": {"walls.kind": "very-rough"},
    "smooth": {"walls.kind": "smooth", "walls.friction_angle_deg": SMOOTH_ANGLE_DEG["dense"]},
}


def entries(program: Program, walls: str = "both", dial: str = "all") -> list[Entry]:
    """Every setting of every dial that the scene knows; several may share a run. References and base come first.

    Parameters
    ----------
    program : what to vary about what.
    walls : very-rough, smooth or both.
    dial : all, or names separated by commas; references and what tells the scatter are always there.

    Raises
    ------
    BadInput
        if there are no such walls or dials.

    """
    chosen = list(program.dials) if walls == "both" else [walls]
    if not set(chosen) <= set(program.dials):
        raise BadInput(f"walls is {walls}; it must be both, or one of {', '.join(program.dials)}")
    names = {one.name for kind in chosen for one in listed(program.dials[kind])}
    wanted = names if dial == "all" else {name.strip() for name in dial.split(",")} | {ROUNDING}
    for name in wanted - names - {ROUNDING}:
        raise BadInput(f"dial is {name}; it must be all, or some of {', '.join(sorted(names))}")
    found = []
    for kind in chosen:
        base = program.base | WALLS[kind]

        def entry(name: str, setting: dict, purpose: str, label: str = "", base=base, kind=kind) -> Entry:
            one = point(Scene(), base | setting)
            return Entry(kind, name, label or words(setting), purpose, one, (*base, *setting))

        found.append(entry(REFERENCE, program.reference, "accuracy"))
        found.append(entry(ROUNDING, {}, "accuracy", "none"))
        for one in listed(program.dials[kind]):
            if one.name in wanted:
                found += [entry(one.name, setting, one.purpose) for setting in one.settings]
    return found


def paths(planned: list[Entry]) -> list[str]:
    """Dotted paths of all that is set anywhere, each once."""
    return list(dict.fromkeys(path for entry in planned for path in entry.paths))


def runs(planned: list[Entry]) -> dict[str, Point]:
    """The points of the entries by their keys, each once."""
    return {entry.point.key: entry.point for entry in planned}
