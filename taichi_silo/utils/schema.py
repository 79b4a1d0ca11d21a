"""Typed groups of options, and one sentence for what is wrong with the values given for them."""

import types
import typing
from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, ValidationError, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from taichi_silo.utils.messages import near, sentence, shown
from taichi_silo.utils.number_words import with_point
from taichi_silo.utils.unit_endings import in_known_unit

TABLE, TABLES = "table", "tables"  # tags of a field that takes a table or an array of them
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
    WITH_TABLE: ClassVar[bool] = False  # whether sentences name its values with their table

    @field_validator("*", mode="before")
    @classmethod
    def _no_truth(cls, given: Any, info: ValidationInfo) -> Any:
        if _holds_truth(given) and not _takes_truth(cls.model_fields[str(info.field_name)].annotation):
            raise PydanticCustomError("truth", "Input should be a number or a word, not true or false")
        return given


def _holds_truth(given: Any, deep: int = 2) -> bool:
    """Whether a value is true or false, or a list, or list of lists, that holds such."""
    if deep and isinstance(given, list | tuple):
        return any(_holds_truth(one, deep - 1) for one in given)
    return isinstance(given, bool)


def _takes_truth(annotation: Any) -> bool:
    """Whether a field may be true or false."""
    return annotation in (bool, Any) or any(map(_takes_truth, typing.get_args(annotation)))


def table_in(annotation: Any) -> type[Options] | None:
    """The table that a field holds, alone, or in a tuple, or beside None; None if it holds values."""
    if isinstance(annotation, type) and issubclass(annotation, Options):
        return annotation
    if typing.get_origin(annotation) is typing.Annotated:
        return table_in(typing.get_args(annotation)[0])
    if typing.get_origin(annotation) in (typing.Union, types.UnionType, tuple, list):
        return next(filter(None, map(table_in, typing.get_args(annotation))), None)
    return None


def one_sentence(error: ValidationError) -> str:
    """The first thing that is wrong, with the name, the value and what would be right."""
    errors = error.errors(include_url=False)
    first = errors[0]
    if first["type"] == "missing":  # under another name, perhaps
        others = (one for one in errors if one["type"] == "extra_forbidden" and one["loc"][:-1] == first["loc"][:-1])
        first = next(others, first)
    kind, context = first["type"], first.get("ctx", {})
    if kind == "value_error":
        return sentence(first["msg"].removeprefix("Value error, "))
    names, options = _names(error.title, first["loc"])
    path = ".".join(names)
    if kind == "extra_forbidden":
        return sentence(f"{path} is not a parameter of a scene{_hint(names, options, first['input'])}")
    if kind == "missing":
        return sentence(f"{path} is missing; it must be given")
    if kind in ("too_long", "too_short"):
        limit = f"at most {context['max_length']}" if kind == "too_long" else f"at least {context['min_length']}"
        return sentence(f"{path} has {context.get('actual_length') or 'too many'} entries; it must have {limit}")
    of_value = [_rule(one) for one in errors if one["loc"][: len(names)] == first["loc"][: len(names)]]
    rule = _range(context, names, options) or " or ".join(dict.fromkeys(of_value))
    if rule == "be a list" and isinstance(first["input"], dict):
        rule += f", each table of which begins with [[{path}]]"
    if "number" in rule and (right := with_point(first["input"])):
        rule += f": write {right}, with a point"
    return sentence(f"{_short(names, options)} is {shown(first['input'])}; it must {rule}")


def _range(context: dict[str, Any], names: list[str], options: type[Options] | None) -> str:
    """The whole range of a number that is beyond one of its ends; empty if something else is wrong."""
    ends = {key: limit for key, limit in context.items() if key in LIMITS}
    field = options.model_fields.get(names[-1]) if ends and options is not None else None
    for rule in field.metadata if field is not None else ():
        ends |= {key: getattr(rule, key) for key in LIMITS if hasattr(rule, key)}
    words = " and ".join(f"{word} {ends[key]:g}" for key, word in LIMITS.items() if key in ends)
    return f"be {words}" if words else ""


def _names(title: str, place: tuple[int | str, ...]) -> tuple[list[str], type[Options] | None]:
    """Names and numbers on the way to a value, without the types that pydantic tried there, and the type of its table.

    `title` is the name of the outermost type.
    """
    table = next((one for one in _all_options(Options) if one.__name__ == title), None)
    names: list[str] = []
    inside = table
    for number, part in enumerate(place):
        fields = inside.model_fields if inside is not None else None
        if isinstance(part, int):
            names.append(shown(part))
        elif part in (TABLE, TABLES) and number and part not in (fields or {}):
            continue  # which of both was tried
        elif fields is None and inside is None and number and table is not None:
            break  # within a value: the name of a type
        else:
            names.append(shown(part))
            field = (fields or {}).get(part)
            if number + 1 < len(place):
                inside = table_in(field.annotation) if field is not None else None
    return names or ["scene"], inside


def _all_options(kind: type[Options]) -> Iterator[type[Options]]:
    for one in kind.__subclasses__():
        yield one
        yield from _all_options(one)


def _hint(names: list[str], options: type[Options] | None, value: Any) -> str:
    """What was perhaps meant by a name that is not known, and by its value if the name ends in another unit."""
    known = list(options.model_fields) if options is not None else []
    meant = in_known_unit(names[-1], value, known) or near(names[-1], known, 0.4)
    before = "".join(f"{name}." for name in names[:-1])
    if meant:
        return f"; did you mean {before}{meant}?"
    return f"; there {'are' if len(known) > 1 else 'is'} {', '.join(before + name for name in known)}" if known else ""


def _short(names: list[str], options: type[Options] | None) -> str:
    """The name of a value in a sentence: its last part, in lists its path; walls.kind is called walls."""
    if any(name.isdigit() for name in names) or (options is not None and options.WITH_TABLE):
        return ".".join(names)
    return names[-2] if names[-1] == "kind" and len(names) > 1 else names[-1]


def _rule(error: Any) -> str:
    """What a value must be, from pydantic's message."""
    if error["type"] in RULES:
        return RULES[error["type"]]
    message = " ".join(error["msg"].split()).split(", unable")[0].removeprefix("Input should ")
    return message[:1].lower() + message[1:]
