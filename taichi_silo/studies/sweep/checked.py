"""A table of a sweep's file as its type, or a sentence that says what is wrong with it."""

from typing import TypeVar

from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options, one_sentence

Kind = TypeVar("Kind", bound=Options)


def checked(kind: type[Kind], given: dict, before: str = "") -> Kind:
    """Of what a file holds under the dotted name `before`.

    Raises
    ------
    BadInput
        if a name is unknown, with the one that was perhaps meant, or a value is not possible.

    """
    for name in given:
        if name not in kind.model_fields:
            meant = near(name, kind.model_fields, 0.5)
            words = f"did you mean {before}{meant}?" if meant else f"there are {', '.join(kind.model_fields)}"
            raise BadInput(f"{before}{shown(name)} is not a parameter of a sweep; {words}")
    try:
        return kind.model_validate(given)
    except ValidationError as error:
        raise BadInput(f"{before}{one_sentence(error)}" if _of_name(error) else one_sentence(error)) from error


def _of_name(error: ValidationError) -> bool:
    """Whether the sentence begins with the name of what is wrong."""
    return error.errors()[0]["type"] != "value_error"
