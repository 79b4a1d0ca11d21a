"""Which runs a chart needs: every value of every varied setting about the base, and each pair of walls' reference."""

from dataclasses import dataclass

from taichi_silo.cli.model_silo import SMOOTH_ANGLE_DEG
from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Scene
from validation.accuracy.parameter_set import ParameterSet, parameter_set
from validation.accuracy.varied_settings import Program, known_to_the_scene, words

REFERENCE, ROUNDING = "reference", "rounding"
WALLS = {  # with dense sand
    "very-rough": {"walls.kind": "very-rough"},
    "smooth": {"walls.kind": "smooth", "walls.friction_angle_deg": SMOOTH_ANGLE_DEG["dense"]},
}


@dataclass(frozen=True)
class ChartRow:
    """One row of the chart.

    Attributes
    ----------
    walls, varied, setting : the pair of walls, what is varied, and its value in words.
    purpose : see `VariedSetting`.
    parameters : of the run; several rows may share one.
    paths : dotted paths of all that was set.

    """

    walls: str
    varied: str
    setting: str
    purpose: str
    parameters: ParameterSet
    paths: tuple[str, ...]


def chart_rows(program: Program, walls: str = "both", varied: str = "all") -> list[ChartRow]:
    """Every value of every varied setting that the scene knows. References and base come first.

    Parameters
    ----------
    program : what to vary about what.
    walls : very-rough, smooth or both.
    varied : all, or names separated by commas; references and what tells the scatter are always there.

    Raises
    ------
    BadInput
        if there are no such walls or settings.

    """
    chosen = list(program.varied) if walls == "both" else [walls]
    if not set(chosen) <= set(program.varied):
        raise BadInput(f"walls is {walls}; it must be both, or one of {', '.join(program.varied)}")
    names = {one.name for kind in chosen for one in known_to_the_scene(program.varied[kind])}
    wanted = names if varied == "all" else {name.strip() for name in varied.split(",")} | {ROUNDING}
    for name in wanted - names - {ROUNDING}:
        raise BadInput(f"dial is {name}; it must be all, or some of {', '.join(sorted(names))}")
    found = []
    for kind in chosen:
        base = program.base | WALLS[kind]

        def row(name: str, setting: dict, purpose: str, label: str = "", base=base, kind=kind) -> ChartRow:
            parameters = parameter_set(Scene(), base | setting)
            return ChartRow(kind, name, label or words(setting), purpose, parameters, (*base, *setting))

        found.append(row(REFERENCE, program.reference, "accuracy"))
        found.append(row(ROUNDING, {}, "accuracy", "none"))
        for one in known_to_the_scene(program.varied[kind]):
            if one.name in wanted:
                found += [row(one.name, setting, one.purpose) for setting in one.settings]
    return found


def paths(planned: list[ChartRow]) -> list[str]:
    """Dotted paths of all that is set anywhere, each once."""
    return list(dict.fromkeys(path for row in planned for path in row.paths))


def runs(planned: list[ChartRow]) -> dict[str, ParameterSet]:
    """The parameter sets of the rows by their keys, each once."""
    return {row.parameters.key: row.parameters for row in planned}
