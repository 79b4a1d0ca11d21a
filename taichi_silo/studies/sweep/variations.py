"""Which scenes a batch has: files, each with every combination of the variations; each under a readable name."""

import itertools
import math
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.runs.run_folder import named, parameters
from taichi_silo.scene import sands
from taichi_silo.scene.dotted_paths import changed, default, hint, known
from taichi_silo.scene.scene import Machine, Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import one_sentence

SAND = "sand"  # a path of its own: all constants of a sand by its name
DEFAULT = "default"  # the word for what a scene has without being told
MOST_RUNS = 10_000
LONGEST_WORD = 1000  # letters of a value
LONGEST_NAME = 200  # of a folder; file systems take 255
REFUSED = {
    "sand.name": "it is only a label, a sand with its constants is chosen by sand=NAME",
    "machine.threads": "each run of a batch has one thread",
}
UNITS = re.compile(r"_(m_per_s2?|kg_per_m3|deg|Pa|m|s)$")


@dataclass(frozen=True)
class Variation:
    """A dotted path of the scene, and its values: the words of a command line, or what a TOML file holds."""

    path: str
    values: tuple

    def __post_init__(self):
        refuse(self.path)
        _few(len(self.values))
        words = [as_word(value) for value in self.values]
        twice = [word for word, count in Counter(words).items() if count > 1]
        if twice:
            raise BadInput(f"{self.path} varies; the value {shown(twice[0])} is there twice")
        if not words:
            raise BadInput(f"{self.path} varies; it must have a value")


def refuse(path: str) -> None:
    """Refuse a path that cannot vary; raises BadInput if the scene has no such path, or its value is not for that."""
    if path in REFUSED:
        raise BadInput(f"{path} varies; {REFUSED[path]}")
    if path != SAND and not known(path):
        raise BadInput(f"{shown(path)} varies; a scene has no such value{hint(path) or ', every one is in a run.toml'}")


def variation(text: str) -> Variation:
    """Of `PATH=V1,V2,...`.

    Raises BadInput if it does not read so, the scene has no such path, or a value is there twice.
    """
    path, equals, listed = text.partition("=")
    path, words = path.strip(), tuple(word.strip() for word in listed.split(","))
    if not equals or not path or not all(words):
        raise BadInput(f"vary is {shown(text)}; it must be PATH=V1,V2,..., such as flow.speed_m_per_s=0.002,0.005")
    return Variation(path, words)


def as_word(value) -> str:
    """A value as a name shows it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "+".join(f"{name}-{as_word(inner)}" for name, inner in value.items()) or "default"
    if isinstance(value, list | tuple):
        return "+".join(map(as_word, value)) or "none"
    word = shown(value, LONGEST_WORD)
    return Path(word).stem if word.lower().endswith(".toml") else word


def bases(files: list[Path]) -> dict[str, Scene]:
    """The scenes of files by a short name, of one thread each; the default scene, without a name, if there are none.

    Raises BadInput if a file cannot be read or its values are not possible.
    """
    if not files:
        return {"": Scene(machine=Machine(threads=1))}
    found = {}
    for file in files:
        name = named(file)
        number, free = 2, name
        while free in found:
            free, number = f"{name}-{number}", number + 1
        found[free] = read_scene(file, threads=1)
    return found


def product(variations: list[Variation]) -> dict[str, dict]:
    """Every combination of the variations, by a name that says what was varied: the values by their paths.

    Raises BadInput if the combinations are too many, or two have one name.
    """
    paths = [one.path for one in variations]
    _few(math.prod(len(one.values) for one in variations))
    settings = [dict(zip(paths, values, strict=True)) for values in itertools.product(*(v.values for v in variations))]
    found = {_name(setting): setting for setting in settings}
    if len(found) < len(settings):
        raise BadInput("two runs would have one name; give the files that are varied other names")
    return found


def scenes(base: dict[str, Scene], settings: dict[str, dict]) -> dict[str, Scene]:
    """Every base with each of the settings, by both names.

    Raises BadInput if a setting is not possible, a name is too long, or the runs are too many.
    """
    _few(len(base) * len(settings))
    found = {}
    for start, scene in base.items():
        for words, setting in settings.items():
            name = "_".join(filter(None, (start, words))) or "default"
            if len(name) > LONGEST_NAME:
                letters = f"{len(name)} letters; at most {LONGEST_NAME} are allowed, vary less"
                raise BadInput(f"folder {shown(name)} has {letters}")
            if name in found:
                raise BadInput(f"two runs would be called {name}; give their files other names")
            found[name] = made(scene, setting, start)
    return found


def _few(count: int) -> None:
    if count > MOST_RUNS:
        raise BadInput(f"the variations make {count} runs; at most {MOST_RUNS} are allowed")


def differences(found: dict[str, Scene], varied: list[str]) -> list[str]:
    """Dotted paths that varied or in which the scenes differ, each once: the columns of the table."""
    flat = [_flat(parameters(scene)) for scene in found.values()]
    paths = dict.fromkeys(path for tables in flat for path in tables)
    named = dict.fromkeys(path if path != SAND else "sand.name" for path in varied)
    asked = [path for path in named if not any(inner.startswith(f"{path}.") for inner in paths)]  # no whole tables
    others = [path for path in paths if path not in asked]
    return asked + [path for path in others if len({str(tables.get(path)) for tables in flat}) > 1]


def used(scene: Scene, paths: list[str]) -> dict:
    """What a scene uses at dotted paths; None where it has nothing."""
    tables = _flat(parameters(scene))
    return {path: tables.get(path) for path in paths}


def made(base: Scene, setting: dict, start: str = "") -> Scene:
    """A scene with values at dotted paths, and a sand by its name.

    Raises BadInput if they are not possible; it tells all of them, after the name `start`.
    """
    try:
        following = {path for path, value in setting.items() if value == DEFAULT and _follows(base, path)}
        rest = {
            path: value if value != DEFAULT else default(path)
            for path, value in setting.items() if path != SAND and path not in following
        }  # fmt: skip
        if SAND in setting:
            own = sands.sand(setting[SAND], _number(rest.get("sand.void_ratio", base.sand.void_ratio)),
                             law=base.sand.law, intergranular=base.sand.intergranular)  # fmt: skip
            base = base.model_copy(update={"sand": own})
        if rest.get("walls.kind") == "very-rough":  # a friction angle that is there is for the smooth walls of others
            rest["walls.friction_angle_deg"] = None
        return changed(_untold(base, following), rest)
    except (ValidationError, ValueError) as error:
        sentence = one_sentence(error) if isinstance(error, ValidationError) else str(error)
        given = (f"{path}={as_word(value)}" for path, value in setting.items())
        where = " ".join([*([start] if start else []), *given])
        raise BadInput(f"{where}: {sentence}" if where else sentence) from error


def _follows(scene: Scene, path: str) -> bool:
    """Whether what stands at a path follows the silo where it is not told."""
    table, _, name = path.partition(".")
    return table in ("grid", "flow") and name in type(getattr(scene, table))().chosen


def _untold(scene: Scene, paths: set[str]) -> Scene:
    """The scene as if nothing had been told at some paths."""
    for path in paths:
        table, _, name = path.partition(".")
        part = getattr(scene, table).model_copy()
        part.__pydantic_fields_set__.discard(name)
        scene = scene.model_copy(update={table: part})
    return scene


def _number(word: str | float) -> float:
    try:
        return float(word)
    except (TypeError, ValueError, OverflowError) as error:
        raise BadInput(f"void ratio is {shown(word)}; it must be a number") from error


def _name(setting: dict) -> str:
    """Each varied value after the last word of its path, without its unit."""
    lasts, parts = [path.split(".")[-1] for path in setting], []
    for path, value in setting.items():
        last = path.split(".")[-1]
        short = path.split(".")[-2] if last == "kind" else UNITS.sub("", last)
        if lasts.count(last) > 1:
            short = path
        parts.append(f"{short}-{re.sub(r'[^A-Za-z0-9.+-]', '-', as_word(value))}")
    return "_".join(parts)


def _flat(tables: dict, before: str = "") -> dict:
    """Values by their dotted paths, but for the number of threads."""
    found: dict[str, object] = {}
    for name, inner in tables.items():
        if isinstance(inner, tuple | list) and inner and isinstance(inner[0], dict):
            inner = dict(enumerate(inner))
        found |= _flat(inner, f"{before}{name}.") if isinstance(inner, dict) else {f"{before}{name}": inner}
    return {path: inner for path, inner in found.items() if not path.startswith("machine.threads")}
