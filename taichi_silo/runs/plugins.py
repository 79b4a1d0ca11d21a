"""Parts of a user's own: laws, contacts, fields and observers that are registered from outside the package."""

import os
import re
from types import ModuleType
from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.mpm import own_parts
from taichi_silo.runs import observers
from taichi_silo.runs.observers import Observer
from taichi_silo.runs.point_fields import FIELDS, Field
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.walls import Walls
from taichi_silo.utils import plugin_files
from taichi_silo.utils.messages import shown

NAME = re.compile(r"[a-z][a-z0-9_-]{0,59}")
TAKEN = {"law": Sand.LAWS, "contact": Walls.KINDS, "field": tuple(FIELDS), "observer": ()}


def register(name: str, part: Any) -> None:
    """Make a law, a contact, a field or an observer known by a name; one that was registered before is replaced.

    Parameters
    ----------
    name : small letters, digits, - and _; of a law what `sand.law` says, of a contact `walls.kind`, of a field the
        `field` of `render` and a column of exports; of an observer what a reader sees.
    part : the class of a law (it has `rate`) or of a contact (it has `touch`), a `Field`, or a class of observers, of
        which every run gets one.

    Raises
    ------
    BadInput
        if the name is taken, or the part breaks its contract or a rule of formulas.

    """
    kind = _kind(part)
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise BadInput(f"name is {shown(name)}; it must begin with a small letter, and have letters, digits, - and _")
    if name in TAKEN[kind]:
        raise BadInput(f"name is {name}; a {kind} of the package has it, give another one")
    if kind == "law":
        own_parts.check_law(part)
        own_parts.LAWS[name] = part
    elif kind == "contact":
        own_parts.check_contact(part)
        own_parts.CONTACTS[name] = part
    elif kind == "field":
        FIELDS[name] = part
    else:
        observers.REGISTERED[name] = part


def load_plugin(file: str | os.PathLike) -> ModuleType:
    """Run a Python file that registers parts, as `taichi-silo --plugin FILE` does; once in a process.

    Sweeps and studies of convergence load it too, in each of their processes.

    Raises
    ------
    BadInput
        if there is no such file, it cannot be run, or a part breaks a rule.

    """
    return plugin_files.load(os.fspath(file))


def _kind(part: Any) -> str:
    if isinstance(part, Field):
        return "field"
    if isinstance(part, type) and issubclass(part, Observer):
        return "observer"
    if isinstance(part, type) and hasattr(part, "rate"):
        return "law"
    if isinstance(part, type) and hasattr(part, "touch"):
        return "contact"
    raise BadInput(
        f"part is {shown(getattr(part, '__name__', part))}; it must be the class of a law (with rate), of a contact "
        "(with touch) or of observers, or a Field"
    )
