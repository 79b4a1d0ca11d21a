"""Scenes from TOML files: one's own, or the run.toml of a run."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.scene import sands
from taichi_silo.scene.dotted_paths import put
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.scene import Scene
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import one_sentence

LONGEST_CHANGE = 10_000  # letters of a PATH=VALUE
PROGRAM = "program"  # the table of run.toml that says what computed it


def read_scene(file: Path, changes: Iterable[str] = (), threads: int | None = None) -> Scene:
    """The scene of a file.

    Raises BadInput if the file cannot be read or its values are not possible.

    Parameters
    ----------
    file : TOML; what it leaves out takes the defaults. In its table `sand` the name of a published sand stands for all
        of its constants that are not given. A table `program`, as a run leaves it, is passed over.
    changes : `PATH=VALUE` each, over what the file says.
    threads : on which to compute, if not as in the file.

    """
    tables = read_tables(file, changes)
    if threads is not None and isinstance(tables.setdefault("machine", {}), dict):  # its type refuses what is no table
        tables["machine"]["threads"] = threads
    try:
        return Scene.model_validate(tables)
    except ValidationError as error:
        raise BadInput(f"{file}: {one_sentence(error)}") from error


def read_tables(file: Path, changes: Iterable[str] = ()) -> dict[str, Any]:
    """The tables of a scene file, not yet checked, with changes over them and the constants of a sand that is named.

    Raises BadInput if the file cannot be read, a change is none, or the sand is not known.
    """
    tables = bounded_reading.toml(file, "a scene")
    tables.pop(PROGRAM, None)
    for change in changes:
        _apply(tables, change)
    try:
        return _named(tables)
    except BadInput as error:
        raise BadInput(f"{file}: {error}") from error


def scene_of(tables: dict) -> Scene:
    """The scene of tables, with the constants of a published sand that is named in them.

    Raises BadInput if a sand is named that is not published, and its constants are not all given; ValidationError if
    the values are not possible.
    """
    return Scene.model_validate(_named(tables))


def _named(tables: dict) -> dict:
    """The tables with the constants of a published sand that is named in them."""
    sand = tables.get("sand")
    return tables | {"sand": _with_constants(sand)} if isinstance(sand, dict) and "name" in sand else tables


def _with_constants(sand: dict) -> dict:
    known, name = sands.published(), sand["name"]
    if not isinstance(name, str):
        return sand  # said by the type
    if name in known:
        return sands.constants(known[name]) | sand
    needed = sands.constants(known["karlsruhe"])
    missing = [key for key in needed if key not in sand]
    if not missing:
        return sand
    meant = near(name.lower(), known)
    if meant:
        raise BadInput(f"sand.name is {shown(name)}; did you mean {meant}?")
    unknown = [key for key in sand if key not in Sand.model_fields]
    if unknown:  # said by the type, and better
        return sand
    raise BadInput(
        f"sand.name is {shown(name)}; it must be one of {', '.join(known)}, or come with all its constants: "
        f"{missing[0]} is missing{sands.only_theory(name)}"
    )


def _apply(tables: dict[str, Any], change: str) -> None:
    """Set the value of PATH=VALUE, which is written as in TOML; a word without quotes is a text."""
    path, equals, text = change.partition("=")
    names = [name.strip() for name in path.split(".")]
    if len(change) > LONGEST_CHANGE:
        raise BadInput(f"set is {shown(change)}; it has {len(change)} letters, at most {LONGEST_CHANGE} are allowed")
    if not equals or not all(names):
        raise BadInput(f"set is {shown(change)}; it must be PATH=VALUE, such as flow.speed_m_per_s=0.005")
    try:
        value = bounded_reading.parsed(f"value = {text.strip()}")
    except ValueError:
        value = {}
    put(tables, ".".join(names), value["value"] if len(value) == 1 else text.strip())
