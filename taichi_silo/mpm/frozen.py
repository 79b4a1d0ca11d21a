"""Frozen dataclasses of which kernels take objects as constants: laws, shapes, walls and the like.

Quadrants hands an object of a dataclass to a kernel field by field, without its functions. Here objects stay whole in
both languages, because a class does not show its fields; `dataclasses.replace` and the like do not know it therefore.
"""

import dataclasses
from typing import TypeVar, dataclass_transform

SHOWN, HIDDEN = "__dataclass_fields__", "_hidden_fields"
T = TypeVar("T")


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def frozen(kind: type[T]) -> type[T]:
    """The class as a frozen dataclass that does not show its fields."""
    bases = [base for base in kind.__mro__[1:] if HIDDEN in vars(base)]
    for base in bases:  # from which a dataclass takes its first fields
        setattr(base, SHOWN, vars(base)[HIDDEN])
    made = dataclasses.dataclass(frozen=True)(kind)
    for base in (made, *bases):
        setattr(base, HIDDEN, vars(base)[SHOWN])
        delattr(base, SHOWN)
    return made


def replaced(one: T, **changes: object) -> T:
    """Another object of a frozen class, with some of its fields changed."""
    return type(one)(**{name: getattr(one, name) for name in getattr(one, HIDDEN)} | changes)
