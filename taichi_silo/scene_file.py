"""Scenes from TOML files: one's own, or the run.toml of a run."""

import difflib
import tomllib
from collections.abc import Iterable
from pathlib import Path

from pydantic import ValidationError

from taichi_silo import sands
from taichi_silo.faults import BadInput
from taichi_silo.sand import Sand
from taichi_silo.scene import Scene
from taichi_silo.table import one_sentence

LARGEST = 10_000_000  # bytes of a scene file
PROGRAM = "program"  # the table of run.toml that says what computed it


def read_scene(file: Path, changes: Iterable[str] = (), threads: int | None = None) -> Scene:
    """The scene of a file.

    Parameters
    ----------
    file : TOML; what it leaves out takes the defaults. In its table `sand` the name of a published sand stands for all
        of its constants that are not given. A table `program`, as a run leaves it, is passed over.
    changes : `PATH=VALUE` each, over what the file says.
    threads : on which to compute, if not as in the file.

    Raises
    ------
    BadInput
        if the file cannot be read or its values are not possible.

    """
    tables = read_tables(file)
    tables.pop(PROGRAM, None)
    for change in changes:
        _apply(tables, change)
    if threads is not None:
        tables["machine"] = tables.get("machine", {}) | {"threads": threads}
    try:
        return scene_of(tables)
    except ValidationError as error:
        raise BadInput(f"{file}: {one_sentence(error)}") from error
    except BadInput as error:
        raise BadInput(f"{file}: {error}") from error


def read_tables(file: Path) -> dict:
    """The tables of a TOML file.

    Raises
    ------
    BadInput
        if there is none, or what is there is no TOML.

    """
    file = Path(file).expanduser()
    try:
        if file.is_file() and file.stat().st_size > LARGEST:
            raise BadInput(f"{file} has {file.stat().st_size} bytes; a scene file has at most {LARGEST}")
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        why = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise BadInput(f"{file} cannot be read as a scene: {why}") from error


def scene_of(tables: dict) -> Scene:
    """The scene of tables, with the constants of a published sand that is named in them.

    Raises
    ------
    BadInput
        if a sand is named that is not published, and its constants are not all given.
    ValidationError
        if the values are not possible.

    """
    sand = tables.get("sand")
    if isinstance(sand, dict) and "name" in sand:
        tables = tables | {"sand": _with_constants(sand)}
    return Scene.model_validate(tables)


def _with_constants(sand: dict) -> dict:
    known, name = sands.published(), sand["name"]
    if name in known:
        return {key: value for key, value in known[name].items() if key not in sands.NOTES} | sand
    needed = [key for key in known["karlsruhe"] if key not in sands.NOTES]
    missing = [key for key in needed if key not in sand]
    if not missing:
        return sand
    near = difflib.get_close_matches(str(name).lower(), known, 1)
    if near:
        raise BadInput(f"sand.name is {name}; did you mean {near[0]}?")
    unknown = [key for key in sand if key not in Sand.model_fields]
    if unknown:  # said by the type, and better
        return sand
    raise BadInput(
        f"sand.name is {name}; it must be one of {', '.join(known)}, or come with all its constants: {missing[0]} is "
        "missing"
    )


def _apply(tables: dict, change: str) -> None:
    path, equals, text = change.partition("=")
    names = [name.strip() for name in path.split(".")]
    if not equals or not all(names):
        raise BadInput(f"set is {change}; it must be PATH=VALUE, such as flow.speed_m_per_s=0.005")
    table = tables
    for name in names[:-1]:
        table = _step(table, name, change)
    if isinstance(table, list):
        raise BadInput(f"set is {change}; it must name a value of a table")
    table[names[-1]] = _value(text.strip())


def _step(table, name: str, change: str):
    """The table, or the entry of a list of tables, of this name; a table is made where there is none."""
    if isinstance(table, list):
        if not name.isdigit() or int(name) >= len(table):
            raise BadInput(f"set is {change}; {name} must be a number from 0 to {len(table) - 1}")
        return table[int(name)]
    found = table.setdefault(name, {})
    if not isinstance(found, (dict, list)):
        raise BadInput(f"set is {change}; {name} is a value, not a table")
    return found


def _value(text: str):
    """A value as TOML writes it; a word without quotes is a text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
