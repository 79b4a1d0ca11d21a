"""A typed group of parameters, and what is said when one is wrong."""

import types
import typing

from pydantic import BaseModel, ConfigDict, ValidationError


class Table(BaseModel):
    """A group of parameters: frozen, finite, and no unknown names."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def table_in(annotation) -> type[Table] | None:
    """The table that a field holds, alone, or in a tuple, or beside None; None if it holds values."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return annotation
    if typing.get_origin(annotation) in (typing.Union, types.UnionType, tuple, list):
        return next(filter(None, map(table_in, typing.get_args(annotation))), None)
    return None


def one_sentence(error: ValidationError) -> str:
    """The first thing that is wrong, with the name, the value and what would be right."""
    first = error.errors()[0]
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error":
        return message
    name = str(first["loc"][-1]) if first["loc"] else "scene"
    name = {"kind": "walls"}.get(name, name)
    limits = first.get("ctx", {})
    words = {"gt": "be above", "ge": "be at least", "lt": "be below", "le": "be at most"}
    rules = [f"{words[key]} {limits[key]}" for key in words if key in limits]
    if first["type"] == "extra_forbidden":
        return f"{name} is not a parameter of a scene"
    if first["type"] == "missing":
        return f"{'.'.join(map(str, first['loc']))} is missing; it must be given"
    rule = f"it must {' and '.join(rules)}" if rules else message.lower()
    return f"{name} is {first['input']}; {rule}"
