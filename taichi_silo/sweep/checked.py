"""A table of a sweep's file as its type, or a sentence that says what is wrong with it."""

import difflib
from typing import TypeVar

from pydantic import ValidationError

from taichi_silo.faults import BadInput
from taichi_silo.table import Table, one_sentence

Kind = TypeVar("Kind", bound=Table)


def checked(kind: type[Kind], given: dict, before: str = "") -> Kind:
    """Of what a file holds under the dotted name `before`.

    Raises
    ------
    BadInput
        if a name is unknown, with the one that was perhaps meant, or a value is not possible.

    """
    for name in given:
        if name not in kind.model_fields:
            near = difflib.get_close_matches(name, kind.model_fields, 1, 0.5)
            meant = f"did you mean {before}{near[0]}?" if near else f"there are {', '.join(kind.model_fields)}"
            raise BadInput(f"{before}{name} is not a parameter of a sweep; {meant}")
    try:
        return kind.model_validate(given)
    except ValidationError as error:
        raise BadInput(f"{before}{one_sentence(error)}" if _of_name(error) else one_sentence(error)) from error


def _of_name(error: ValidationError) -> bool:
    """Whether the sentence begins with the name of what is wrong."""
    return error.errors()[0]["type"] != "value_error"
