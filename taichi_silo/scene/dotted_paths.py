"""Values of a scene by dotted path, such as `flow.speed_m_per_s`: their fields, and scenes with other values.

A path leads through tables that a scene may lack, as `silo.outlet.width_m` does, and by number through lists, as
`silo.inserts.0.width_m` does. Setting a value makes the tables on its way.
"""

import typing
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Scene
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options, table_in

MOST_DIGITS = 6  # of the number of an entry in a path


class Place(NamedTuple):
    """One table or value of a scene."""

    path: str  # dotted; the first entry of a list stands for all
    field: FieldInfo  # its type, default, range and description
    table: type[Options] | None  # type of the table that stands here; None if it is a value
    optional: bool  # whether it belongs to a table that a scene may lack, and lacks by default


def places(options: type[Options] = Scene, before: str = "", optional: bool = False) -> Iterator[Place]:
    """All values of a scene in their order, each table before what stands in it, and values before tables."""
    inner: list[Place] = []
    for name, field in options.model_fields.items():
        table, path = table_in(field.annotation), before + name
        if table is None:
            yield Place(path, field, None, optional)
            continue
        many = typing.get_origin(field.annotation) is tuple
        absent = optional or many or type(None) in typing.get_args(field.annotation)
        path = f"{path}.0" if many else path
        inner += [Place(path, field, table, absent), *places(table, f"{path}.", absent)]
    yield from inner


def annotation(path: str) -> Any:
    """The type of what stands at a path; None if a scene has no such path."""
    kind: Any = Scene
    for name in path.split("."):
        many, table = typing.get_origin(kind) is tuple, table_in(kind)
        if is_number(name):
            kind = table if many or _may_be_several(kind) else None
        elif float in (found := numbers_by_name(kind)):
            kind = found[1]
        else:
            field = table.model_fields.get(name) if table is not None and not many else None
            kind = None if field is None else field.annotation
        if kind is None:
            return None
    return kind


def _may_be_several(kind: Any) -> bool:
    """Whether a field takes an array of tables beside a single one."""
    return typing.get_origin(kind) is tuple or any(map(_may_be_several, typing.get_args(kind)))


def numbers_by_name(kind: Any) -> tuple:
    """Types of names and values of a dictionary of numbers, alone or beside None; empty if it is none."""
    parts = (kind, *typing.get_args(kind))
    return next((typing.get_args(one) for one in parts if typing.get_origin(one) is dict), ())


def known(path: str) -> bool:
    """Whether a path names a value of the scene."""
    kind = annotation(path)
    return kind is not None and not (isinstance(kind, type) and issubclass(kind, Options))


def whole(path: str) -> bool:
    """Whether the values at a path are whole numbers."""
    kind = annotation(path)
    return kind is int or int in typing.get_args(kind)


def is_number(name: str) -> bool:
    """Whether a part of a path is the number of an entry."""
    return name.isascii() and name.isdigit() and len(name) <= MOST_DIGITS


def hint(path: str) -> str:
    """The path that was perhaps meant, in words; empty if none is near."""
    paths = [place.path for place in places() if place.table is None]
    meant = near(path, paths)
    if not meant:  # another table, or none
        lasts = {one.split(".")[-1]: one for one in reversed(paths)}
        meant = lasts.get(near(path.split(".")[-1], lasts) or "")
    return f"; did you mean {meant}?" if meant else ""


def changed(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """The scene with values at dotted paths.

    Raises BadInput if it has no such path; ValidationError if the values are not possible.
    """
    return Scene.model_validate(tables_with(scene, values))


def tables_with(scene: Scene, values: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a scene with values at dotted paths, not yet checked.

    Raises BadInput if it has no such path.
    """
    tables = scene.model_dump()
    for table in ("grid", "flow"):
        for name in getattr(scene, table).chosen:
            del tables[table][name]  # that of another silo is another one
    for path, value in values.items():
        if not known(path):
            raise BadInput(f"setting is {shown(path)}; a scene has no such value{hint(path)}")
        put(tables, path, value)
    return tables


def put(tables: dict[str, Any], path: str, value: Any) -> None:
    """Set the value at a dotted path of tables; where it is None, tables that are not there are not made for it.

    Raises BadInput if the path leads through a value, or to no entry of a list.
    """
    *names, last = path.split(".")
    table: Any = tables
    for name in names:
        if isinstance(table, list):
            table = _entry(table, name, path, make=value is not None)
        elif isinstance(table, dict):
            if table.get(name) is None and value is not None:
                table[name] = {}
            elif isinstance(table.get(name), tuple):
                table[name] = list(table[name])
            table = table.get(name)
        if table is None:
            return
        if not isinstance(table, dict | list):
            raise BadInput(f"setting is {shown(path)}; {shown(name)} is a value, not a table")
    if not isinstance(table, dict):
        raise BadInput(f"setting is {shown(path)}; it must name a value of a table")
    table[last] = value


def _entry(entries: list[Any], name: str, path: str, make: bool) -> Any:
    """An entry of a list by its number; the next one is made if it is wanted."""
    number = int(name) if is_number(name) else len(entries) + 1
    if number > len(entries):
        raise BadInput(f"setting is {shown(path)}; {len(entries)} are there, so the next has number {len(entries)}")
    if number == len(entries) and make:
        entries.append({})
    return entries[number] if number < len(entries) else None


def value(scene: Any, path: str) -> Any:
    """What a scene has at a dotted path; None where it lacks the table."""
    found = scene
    for name in path.split("."):
        if isinstance(found, tuple):
            found = found[int(name)] if is_number(name) and int(name) < len(found) else None
        else:
            found = None if found is None else getattr(found, name)
    return found


def default(path: str) -> Any:
    """What a scene has at a dotted path without being told; None if it must be told."""
    parent, _, last = path.rpartition(".")
    table = table_in(annotation(parent)) if parent else Scene
    assert table is not None, path
    found = table.model_fields[last].get_default(call_default_factory=True)
    return None if found is PydanticUndefined else found
