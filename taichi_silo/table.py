"""A typed group of parameters, and what is said when one is wrong."""

import difflib
import types
import typing

from pydantic import BaseModel, ConfigDict, ValidationError

LIMITS = {"gt": "be above", "ge": "be at least", "lt": "be below", "le": "be at most"}


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
    names, table = _names(error.title, first["loc"])
    path = ".".join(names)
    if first["type"] == "extra_forbidden":
        return f"{path} is not a parameter of a scene{_hint(names, table)}"
    if first["type"] == "missing":
        return f"{path} is missing; it must be given"
    words = [" ".join(e["msg"].split()) for e in error.errors() if _names(error.title, e["loc"])[0] == names]
    rules = [f"{LIMITS[key]} {limit}" for key, limit in first.get("ctx", {}).items() if key in LIMITS]
    rule = " and ".join(rules) or " or ".join(dict.fromkeys(map(_rule, words)))
    return f"{_short(names)} is {_value(first['input'])}; it must {rule}"


def _names(title: str, place: tuple) -> tuple[list[str], type[Table] | None]:
    """Names and numbers on the way to a place of a table, without the types that were tried there, and its table."""
    table = next((one for one in _tables(Table) if one.__name__ == title), None)
    names, inside = [], table
    for number, part in enumerate(place):
        fields = inside.model_fields if inside is not None else None
        if isinstance(part, int):
            names.append(str(part))
        elif fields is None and inside is None and number and table is not None:
            break  # within a value: the name of a type
        else:
            names.append(str(part))
            field = (fields or {}).get(part)
            if number + 1 < len(place):
                inside = table_in(field.annotation) if field is not None else None
    return names or ["scene"], inside


def _tables(kind: type):
    for one in kind.__subclasses__():
        yield one
        yield from _tables(one)


def _hint(names: list[str], table: type[Table] | None) -> str:
    known = list(table.model_fields) if table is not None else []
    near = difflib.get_close_matches(names[-1], known, 1, 0.4)
    before = "".join(f"{name}." for name in names[:-1])
    if near:
        return f"; did you mean {before}{near[0]}?"
    return f"; there {'are' if len(known) > 1 else 'is'} {', '.join(before + name for name in known)}" if known else ""


def _short(names: list[str]) -> str:
    """A parameter as a sentence calls it: the kind of something is that thing."""
    if any(name.isdigit() for name in names):
        return ".".join(names)
    return names[-2] if names[-1] == "kind" and len(names) > 1 else names[-1]


def _rule(message: str) -> str:
    """Of pydantic's words what must be."""
    message = message.split(", unable")[0].removeprefix("Input should ")
    return message[:1].lower() + message[1:]


def _value(value) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
