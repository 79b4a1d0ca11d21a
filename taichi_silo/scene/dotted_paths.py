"""Settings by dotted path: which the scene knows, and a scene with some of them changed.

A path leads through tables that a scene may lack, as `silo.outlet.width_m` does, and by number through lists, as
`silo.inserts.0.width_m` does. A setting makes the tables on its way.
"""

import typing
from collections.abc import Iterator

from pydantic_core import PydanticUndefined

from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Scene
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options, table_in

MOST_DIGITS = 6  # of the number of an entry in a path
OUTSIDE = ("precision", "nudge")  # no part of the scene: of the process, and of the start


def known(path: str) -> bool:
    """Whether a path names a value of the scene, or one of `OUTSIDE`."""
    if path in OUTSIDE:
        return True
    kind = _kind(path)
    return kind is not None and not (isinstance(kind, type) and issubclass(kind, Options))


def whole(path: str) -> bool:
    """Whether the values at a path are whole numbers."""
    kind = _kind(path)
    return kind is int or int in typing.get_args(kind)


def is_number(name: str) -> bool:
    """Whether a part of a path is the number of an entry."""
    return name.isascii() and name.isdigit() and len(name) <= MOST_DIGITS


def hint(path: str) -> str:
    """The path that was perhaps meant, in words; empty if none is near."""
    paths = list(_paths(Scene))
    meant = near(path, paths)
    if not meant:  # another table, or none
        lasts = {one.split(".")[-1]: one for one in reversed(paths)}
        meant = lasts.get(near(path.split(".")[-1], lasts))
    return f"; did you mean {meant}?" if meant else ""


def changed(scene: Scene, settings: dict) -> Scene:
    """The scene with values at dotted paths; those of `OUTSIDE` are passed over.

    Raises
    ------
    BadInput
        if it has no such path.
    ValidationError
        if the values are not possible.

    """
    tables = scene.model_dump()
    for path, value in settings.items():
        if path in OUTSIDE:
            continue
        if not known(path):
            raise BadInput(f"setting is {shown(path)}; a scene has no such value{hint(path)}")
        *names, last = path.split(".")
        table = tables
        for name in names:
            table = _inside(table, name, path, make=value is not None)
        if table is not None:
            table[last] = value
    if settings.get("walls.kind") == "very-rough":  # has no friction angle: one that is there is for smooth walls
        tables["walls"]["friction_angle_deg"] = None
    return Scene.model_validate(tables)


def value(scene: Scene, path: str):
    """What a scene has at a dotted path; None where it lacks the table."""
    found = scene
    for name in path.split("."):
        if isinstance(found, tuple):
            found = found[int(name)] if int(name) < len(found) else None
        else:
            found = None if found is None else getattr(found, name)
    return found


def default(path: str):
    """What a scene has at a dotted path without being told; None if it must be told."""
    *names, last = path.split(".")
    found = table_in(_kind(".".join(names))).model_fields[last].get_default(call_default_factory=True)
    return None if found is PydanticUndefined else found


def _kind(path: str):
    """The type of what is at a path; None if a scene has no such path."""
    kind = Scene
    for name in path.split("."):
        if is_number(name):
            kind = table_in(kind) if typing.get_origin(kind) is tuple else None
        else:
            table = table_in(kind) if typing.get_origin(kind) is not tuple else None
            field = table.model_fields.get(name) if table is not None else None
            kind = None if field is None else field.annotation
        if kind is None:
            return None
    return kind


def _inside(table, name: str, path: str, make: bool):
    """What stands under a name of a table or a number of a list; if it is to be made, also where there was nothing."""
    if table is None:
        return None
    if isinstance(table, list):
        if int(name) > len(table):
            raise BadInput(f"setting is {shown(path)}; {len(table)} are there, so the next has number {len(table)}")
        if int(name) == len(table) and make:
            table.append({})
        return table[int(name)] if int(name) < len(table) else None
    if table.get(name) is None and make:
        table[name] = {}
    if isinstance(table.get(name), tuple):
        table[name] = list(table[name])
    return table.get(name)


def _paths(table: type[Options], before: str = "") -> Iterator[str]:
    """All paths of values; the first of a list stands for all."""
    for name, field in table.model_fields.items():
        inner, path = table_in(field.annotation), before + name
        if inner is None:
            yield path
        else:
            yield from _paths(inner, f"{path}.0." if typing.get_origin(field.annotation) is tuple else f"{path}.")
