"""Flags made from the typed scene: name, type, default, unit, range and meaning of each come from its field."""

import functools
import inspect
import re
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Annotated, Any

import typer

from taichi_silo.errors import BadInput
from taichi_silo.scene import reference, sands
from taichi_silo.scene.dotted_paths import annotation, is_number, value
from taichi_silo.scene.fidelity import FIDELITIES, STANDARD
from taichi_silo.scene.method_options import MethodOptions
from taichi_silo.scene.scene import Scene
from taichi_silo.utils.messages import shown

ENTRIES = {entry.path: entry for entry in reference.entries()}
NAMES = {  # of flags that are not called as the last part of their path
    "silo.outlet.width_m": "outlet_width", "silo.outlet.position": "outlet_position",
    "silo.hopper.friction_angle_deg": "hopper_friction_angle", "silo.inserts.0.width_m": "insert_width",
    "silo.inserts.0.height_m": "insert_height", "silo.inserts.0.bottom_m": "insert_bottom",
    "silo.inserts.0.friction_angle_deg": "insert_friction_angle", "walls.friction_angle_deg": "wall_friction_angle",
    "method.stress_filter": "filter", "averaging.wall": "averaging_wall",
    "averaging.means": "averaging_means",
}  # fmt: skip
OF_FIDELITY = ("grid.cell_size_m", "flow.speed_m_per_s")  # what a named fidelity may set
TIME_STEP, AUTO = "method.time_step_s", "auto"
DEFAULT = Scene()
METHOD = tuple(f"method.{name}" for name in MethodOptions.model_fields)


def name_of(path: str) -> str:
    """The parameter, and so the flag, of a value of the scene: the end of its path without its unit."""
    *tables, last = path.split(".")
    if path in NAMES or last != "kind":
        return NAMES.get(path, last.removesuffix("_" + _unit_suffix(last)))
    return last if is_number(tables[-1]) else tables[-1]  # the kind of the walls is --walls


@functools.cache
def paths_of_flags() -> dict[str, str]:
    """Flags of scenarios, such as `--cell-size`, and the paths of the values of a scene that they set."""
    found = {"--sand": "sand.name", "--hopper-angle": "silo.hopper.half_angle_deg"}
    for path in ENTRIES:
        found.setdefault(f"--{name_of(path).replace('_', '-')}", path)
    return found


def for_scene_file(words: str, own: Iterable[str]) -> str:
    """Words on flags of scenarios as words on `--set`, where a scene file has no such flag of its own."""
    path = paths_of_flags().get

    def instead(flag: re.Match) -> str:
        return flag[0] if flag[0] in own or path(flag[0]) is None else f"--set {path(flag[0])}="

    return re.sub(r"--[a-z-]+", instead, words).replace("= ", "=")


def refuse_flags_of_scenarios(words: Sequence[str], own: Iterable[str]) -> None:
    """Refuse a flag that scenarios have and a scene file has not, with the `--set` that does the same.

    Raises BadInput.
    """
    for number, word in enumerate(words):
        flag, equals, given = word.partition("=")
        path = paths_of_flags().get(flag)
        if flag in own or not (path or flag == "--fidelity"):
            continue
        if not equals and number + 1 < len(words) and not words[number + 1].startswith("--"):
            given = words[number + 1]
        if path is None:
            right = " and ".join(f"--set {one}=..." for one in OF_FIDELITY)
        else:
            right = f"--set {path}={shown(given) if given else '...'}"
        raise BadInput(f"{flag} is a flag of scenarios, and this is a scene file; give {right}")


def _unit_suffix(name: str) -> str:
    return next((end for end in reference.UNITS if name.endswith(f"_{end}")), "")


def kind_of(path: str) -> Any:
    """What a flag takes: a number or text; what text may be is said by the scene's types."""
    if path == TIME_STEP:
        return str
    inner = typing.get_args(annotation(path)) or (annotation(path),)
    kind = next((one for one in (int, float) if one in inner and not ENTRIES[path].choices), str)
    return kind | None if default_of(DEFAULT, path) is None else kind


def default_of(scene: Scene, path: str) -> Any:
    """What a flag is without being given; None where that depends on other things."""
    if path == TIME_STEP:
        return AUTO
    table, _, name = path.partition(".")
    if path in OF_FIDELITY or path == "machine.threads" or name in getattr(getattr(scene, table), "chosen", ()):
        return None
    return value(scene, path)


def option(path: str, note: str = "") -> Any:
    """Type and help of the flag of a value of the scene, for the signature of a command."""
    entry = ENTRIES[path]
    words = f"{' | '.join(entry.choices)}: {entry.meaning}" if entry.choices else entry.meaning
    words = words.replace("if absent", "if auto" if path == TIME_STEP else "if not given")
    about = (words, f"[{entry.unit}]" if entry.unit else "", f"({entry.limits})" if entry.limits else "")
    if path in OF_FIDELITY:
        note = f"; {entry.default:g} in {STANDARD} fidelity, in a silo of 0.2 m"
    return Annotated[kind_of(path), typer.Option(help=" ".join(filter(None, about)) + note)]


def parameters(scene: Scene, paths: Iterable[str], notes: Mapping[str, str] | None = None) -> list[inspect.Parameter]:
    """Parameters of a command that are flags of values of the scene; notes end the help of some."""
    return [
        inspect.Parameter(name_of(path), inspect.Parameter.KEYWORD_ONLY, default=default_of(scene, path),
                          annotation=option(path, (notes or {}).get(path, "")))
        for path in paths
    ]  # fmt: skip


def given(values: dict[str, Any], paths: Iterable[str]) -> dict[str, Any]:
    """Values by dotted path of flags that were given or have a default.

    Raises BadInput if the time step is neither a number nor "auto".
    """
    found = {path: values[name_of(path)] for path in paths if values.get(name_of(path)) is not None}
    word = found.get(TIME_STEP)
    if word == AUTO:
        del found[TIME_STEP]
    elif word is not None:
        try:
            found[TIME_STEP] = float(word)
        except ValueError as error:
            raise BadInput(f"time step is {word}; it must be auto, or a number of seconds above 0") from error
    return found


class MethodFlags(dict):
    """Values of MethodOptions by their names: a parameter of this type stands for all of their flags."""


def with_method_flags(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, its parameter of type `MethodFlags`, if it has one, spread into the flags of the method."""
    signature = inspect.signature(function)
    group = next((p.name for p in signature.parameters.values() if p.annotation is MethodFlags), None)
    if group is None:
        return function
    others = [p for p in signature.parameters.values() if p.name != group]

    def spread(**values: Any) -> Any:
        own = {path.removeprefix("method."): one for path, one in given(values, METHOD).items()}
        return function(**{p.name: values[p.name] for p in others}, **{group: own})

    return with_parameters(functools.wraps(function)(spread), [*others, *parameters(DEFAULT, METHOD)])


def with_parameters(function: Callable[..., Any], found: list[inspect.Parameter]) -> Callable[..., Any]:
    """The function of keywords, which says that it has these parameters."""
    keywords = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in found]
    function.__signature__ = inspect.Signature(keywords)  # type: ignore[attr-defined]
    function.__annotations__ = {one.name: one.annotation for one in keywords}
    return function


SandFlag = Annotated[
    str, typer.Option(help=f"name of a published sand ({', '.join(sands.published())}), or a TOML file with one's own")
]
LawFlag = option("sand.law")
LengthFlag = option("averaging.characteristic_length_m")
WeightFlag = option("averaging.weight")
ShapeFlag = option("grid.shape")
FidelityFlag = Annotated[
    str, typer.Option(help=f"{' | '.join(FIDELITIES)}: cell size and speed where they are not given")
]
