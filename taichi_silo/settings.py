"""Settings by dotted path: which the scene knows, and a scene with some of them changed."""

from pydantic import BaseModel

from taichi_silo.faults import BadInput
from taichi_silo.scene import Scene

OUTSIDE = ("precision", "nudge")  # no part of the scene: of the process, and of the start


def known(path: str) -> bool:
    """Whether a path names a value of the scene, or one of `OUTSIDE`."""
    table = Scene
    for name in path.split("."):
        fields = table.model_fields if isinstance(table, type) and issubclass(table, BaseModel) else {}
        if name not in fields:
            return path in OUTSIDE
        table = fields[name].annotation
    return not (isinstance(table, type) and issubclass(table, BaseModel))


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
            raise BadInput(f"setting is {path}; a scene has no such value")
        *names, last = path.split(".")
        table = tables
        for name in names:
            table = table[name]
        table[last] = value
    return Scene.model_validate(tables)


def value(scene: Scene, path: str):
    """What a scene has at a dotted path."""
    found = scene
    for name in path.split("."):
        found = getattr(found, name)
    return found
