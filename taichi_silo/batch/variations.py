"""Which scenes a batch has: files, each with every combination of the variations; each under a readable name."""

import itertools
import re
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from taichi_silo import sands
from taichi_silo.faults import BadInput
from taichi_silo.folder import MADE, parameters
from taichi_silo.scene import Machine, Scene
from taichi_silo.scene_file import read_scene
from taichi_silo.settings import OUTSIDE, changed, known, value
from taichi_silo.table import one_sentence

SAND = "sand"  # a path of its own: all constants of a sand by its name
DEFAULT = "default"  # the word for what a scene has without being told
MOST_RUNS = 10_000
LONGEST_NAME = 200  # of a folder; file systems take 255
REFUSED = {
    "sand.name": "it is only a label, a sand with its constants is chosen by sand=NAME",
    "machine.threads": "each run of a batch has one thread",
}
UNITS = re.compile(r"_(m_per_s2?|kg_per_m3|deg|Pa|m|s)$")


@dataclass(frozen=True)
class Variation:
    """A dotted path of the scene, and the words for its values as they were given."""

    path: str
    words: tuple[str, ...]


def variation(text: str) -> Variation:
    """Of `PATH=V1,V2,...`.

    Raises
    ------
    BadInput
        if it does not read so, the scene has no such path, or a value is there twice.

    """
    path, equals, listed = text.partition("=")
    path, words = path.strip(), tuple(word.strip() for word in listed.split(","))
    if not equals or not path or not all(words):
        raise BadInput(f"vary is {text}; it must be PATH=V1,V2,..., such as flow.speed_m_per_s=0.002,0.005")
    if path in REFUSED:
        raise BadInput(f"vary is {text}; {REFUSED[path]}")
    if path != SAND and (not known(path) or path in OUTSIDE):
        raise BadInput(f"vary is {text}; a scene has no value {path}, every one is in the run.toml of a run")
    twice = [word for word in words if words.count(word) > 1]
    if twice:
        raise BadInput(f"vary is {text}; the value {twice[0]} is there twice")
    return Variation(path, words)


def bases(files: list[Path]) -> dict[str, Scene]:
    """The scenes of files by a short name, of one thread each; the default scene, without a name, if there are none.

    Raises
    ------
    BadInput
        if a file cannot be read or its values are not possible.

    """
    if not files:
        return {"": Scene(machine=Machine(threads=1))}
    found = {}
    for file in files:
        name = file.resolve().parent.name if file.name == MADE else file.stem
        number, free = 2, name
        while free in found:
            free, number = f"{name}-{number}", number + 1
        found[free] = read_scene(file, threads=1)
    return found


def scenes(base: dict[str, Scene], variations: list[Variation]) -> dict[str, Scene]:
    """Every base with every combination of the variations, by a name that says what was varied.

    Raises
    ------
    BadInput
        if a combination is not possible, a path is varied twice, a name is too long, or the runs are too many.

    """
    paths = [one.path for one in variations]
    for path in paths:
        if paths.count(path) > 1:
            raise BadInput(f"vary is given twice for {path}; it must name all its values at once")
    count = len(base)
    for one in variations:
        count *= len(one.words)
    if count > MOST_RUNS:
        raise BadInput(f"the variations make {count} runs; at most {MOST_RUNS} are allowed")
    found = {}
    for start, scene in base.items():
        for words in itertools.product(*(one.words for one in variations)):
            setting = dict(zip(paths, words, strict=True))
            name = _name(start, setting)
            if len(name) > LONGEST_NAME:
                raise BadInput(f"folder {name} has {len(name)} letters; at most {LONGEST_NAME} are allowed, vary less")
            if name in found:
                raise BadInput(f"two runs would be called {name}; give their files other names")
            found[name] = _scene(scene, setting, start)
    return found


def differences(found: dict[str, Scene], variations: list[Variation]) -> list[str]:
    """Dotted paths in which the scenes differ or that were asked for, each once: the columns of the table."""
    flat = [_flat(parameters(scene)) for scene in found.values()]
    asked = [one.path if one.path != SAND else "sand.name" for one in variations]
    paths = dict.fromkeys([*asked, *(path for tables in flat for path in tables)])
    return [path for path in paths if path in asked or len({str(tables.get(path)) for tables in flat}) > 1]


def used(scene: Scene, path: str):
    """What a scene uses at a dotted path; None where it has nothing."""
    return _flat(parameters(scene)).get(path)


def _scene(base: Scene, setting: dict[str, str], start: str) -> Scene:
    try:
        rest = {path: word if word != DEFAULT else value(Scene(), path) for path, word in setting.items()
                if path != SAND}  # fmt: skip
        if SAND in setting:
            own = sands.sand(setting[SAND], _number(rest.get("sand.void_ratio", base.sand.void_ratio)),
                             law=base.sand.law, intergranular=base.sand.intergranular)  # fmt: skip
            base = base.model_copy(update={"sand": own})
        return changed(base, rest)
    except (ValidationError, ValueError) as error:
        sentence = one_sentence(error) if isinstance(error, ValidationError) else str(error)
        where = " ".join([*([start] if start else []), *(f"{path}={word}" for path, word in setting.items())])
        raise BadInput(f"{where}: {sentence}" if where else sentence) from error


def _number(word: str | float) -> float:
    try:
        return float(word)
    except ValueError as error:
        raise BadInput(f"void ratio is {word}; it must be a number") from error


def _name(start: str, setting: dict[str, str]) -> str:
    """Of a run and its folder: the file, and each varied value after the last word of its path, without its unit."""
    lasts = [path.split(".")[-1] for path in setting]
    parts = [start] if start else []
    for path, word in setting.items():
        last = path.split(".")[-1]
        short = path.split(".")[0] if last == "kind" else UNITS.sub("", last)
        if lasts.count(last) > 1:
            short = path
        parts.append(f"{short}-{re.sub(r'[^A-Za-z0-9.+-]', '-', word)}")
    return "_".join(parts) or "default"


def _flat(tables: dict, before: str = "") -> dict:
    found = {}
    for name, inner in tables.items():
        found |= _flat(inner, f"{before}{name}.") if isinstance(inner, dict) else {before + name: inner}
    return {path: inner for path, inner in found.items() if not path.startswith("machine.threads")}
