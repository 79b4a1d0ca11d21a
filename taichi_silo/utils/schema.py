"""A typed group of parameters, and what is said when one is wrong."""

import types
import typing
from collections.abc import Iterator

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator
from pydantic_core import PydanticCustomError

from taichi_silo.utils.messages import near, sentence, shown

LIMITS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
RULES = {  # of pydantic's names for what is wrong
    "model_type": "be a table", "model_attributes_type": "be a table", "dict_type": "be a table",
    "tuple_type": "be a list", "list_type": "be a list", "float_type": "be a number", "float_parsing": "be a number",
    "int_type": "be a whole number", "int_parsing": "be a whole number", "int_from_float": "be a whole number",
    "int_parsing_size": "be a whole number", "bool_type": "be true or false", "bool_parsing": "be true or false",
    "string_type": "be text", "string_unicode": "be text", "path_type": "be the path of a file",
}  # fmt: skip


class Options(BaseModel):
    """A group of parameters: frozen, finite, true and false are no numbers, and no unknown names."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _no_truth(cls, given, info):
        if _holds_truth(given) and not _takes_truth(cls.model_fields[info.field_name].annotation):
            raise PydanticCustomError("truth", "Input should be a number or a word, not true or false")
        return given


def _holds_truth(given, deep: int = 2) -> bool:
    if deep and isinstance(given, list | tuple):
        return any(_holds_truth(one, deep - 1) for one in given)
    return isinstance(given, bool)


def _takes_truth(annotation) -> bool:
    return annotation in (bool, typing.Any) or any(map(_takes_truth, typing.get_args(annotation)))


def table_in(annotation) -> type[Options] | None:
    """The table that a field holds, alone, or in a tuple, or beside None; None if it holds values."""
    if isinstance(annotation, type) and issubclass(annotation, Options):
        return annotation
    if typing.get_origin(annotation) in (typing.Union, types.UnionType, tuple, list):
        return next(filter(None, map(table_in, typing.get_args(annotation))), None)
    return None


def one_sentence(error: ValidationError) -> str:
    """The first thing that is wrong, with the name, the value and what would be right."""
    return sentence(_of_first(error))


def _of_first(error: ValidationError) -> str:
    errors = error.errors(include_url=False)
    first = errors[0]
    if first["type"] == "value_error":
        return first["msg"].removeprefix("Value error, ")
    names, table = _names(error.title, first["loc"])
    path = ".".join(names)
    if first["type"] == "extra_forbidden":
        return f"{path} is not a parameter of a scene{_hint(names, table)}"
    if first["type"] == "missing":
        return f"{path} is missing; it must be given"
    if first["type"] in ("too_long", "too_short"):
        return f"{path} has {_count(first)} entries; it must have {_right_count(first['ctx'])}"
    of_value = [e for e in errors if e["loc"][: len(names)] == first["loc"][: len(names)]]
    rule = _range(first, names, table) or " or ".join(dict.fromkeys(map(_rule, of_value)))
    return f"{_short(names)} is {shown(first['input'])}; it must {rule}"


def _range(error, names: list[str], table: type[Options] | None) -> str:
    """The whole range of a number that is beyond one of its ends; empty if something else is wrong."""
    ends = {key: limit for key, limit in error.get("ctx", {}).items() if key in LIMITS}
    field = table.model_fields.get(names[-1]) if ends and table is not None else None
    for rule in field.metadata if field is not None else ():
        ends |= {key: getattr(rule, key) for key in LIMITS if hasattr(rule, key)}
    words = " and ".join(f"{word} {ends[key]:g}" for key, word in LIMITS.items() if key in ends)
    return f"be {words}" if words else ""


def _count(error) -> str:
    """How many entries there are, as far as they were counted."""
    found = error["ctx"].get("actual_length")
    return str(found) if found is not None else "too many"


def _right_count(limits: dict) -> str:
    if "max_length" in limits:
        return f"at most {limits['max_length']}"
    return f"at least {limits['min_length']}"


def _names(title: str, place: tuple) -> tuple[list[str], type[Options] | None]:
    """Names and numbers on the way to a place of a table, without the types that were tried there, and its table."""
    table = next((one for one in _tables(Options) if one.__name__ == title), None)
    names, inside = [], table
    for number, part in enumerate(place):
        fields = inside.model_fields if inside is not None else None
        if isinstance(part, int):
            names.append(shown(part))
        elif fields is None and inside is None and number and table is not None:
            break  # within a value: the name of a type
        else:
            names.append(shown(part))
            field = (fields or {}).get(part)
            if number + 1 < len(place):
                inside = table_in(field.annotation) if field is not None else None
    return names or ["scene"], inside


def _tables(kind: type[Options]) -> Iterator[type[Options]]:
    for one in kind.__subclasses__():
        yield one
        yield from _tables(one)


def _hint(names: list[str], table: type[Options] | None) -> str:
    known = list(table.model_fields) if table is not None else []
    meant = near(names[-1], known, 0.4)
    before = "".join(f"{name}." for name in names[:-1])
    if meant:
        return f"; did you mean {before}{meant}?"
    return f"; there {'are' if len(known) > 1 else 'is'} {', '.join(before + name for name in known)}" if known else ""


def _short(names: list[str]) -> str:
    """A parameter as a sentence calls it: the kind of something is that thing."""
    if any(name.isdigit() for name in names):
        return ".".join(names)
    return names[-2] if names[-1] == "kind" and len(names) > 1 else names[-1]


def _rule(error) -> str:
    """What must be."""
    if error["type"] in RULES:
        return RULES[error["type"]]
    message = " ".join(error["msg"].split()).split(", unable")[0].removeprefix("Input should ")
    return message[:1].lower() + message[1:]
