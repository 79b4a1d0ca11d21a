"""A law on NumPy arrays: the same text of its formulas, with NumPy's functions in place of the language's.

Kernels take the constants of a law as constants of compilation. Here they may be arrays, so that many sets of constants
are followed at once; there is no second copy of any formula.
"""

import dataclasses
import functools
import math
import types
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from taichi_silo.mpm.frozen import HIDDEN
from taichi_silo.mpm.language import of_kernels, ti

LANGUAGE = SimpleNamespace(
    max=np.maximum, min=np.minimum, sqrt=np.sqrt, select=np.where, abs=np.abs, static=lambda value: value
)
MATHS = SimpleNamespace(sin=np.sin, cos=np.cos, sqrt=np.sqrt, exp=np.exp, radians=np.radians, pi=math.pi)
FUNCTIONS: dict[str, Callable] = {  # of `lane_maths`, which ask what a number is while a kernel is compiled
    "power": lambda base, exponent, most=None: np.power(base, exponent),
    "exp_minus": lambda x, most=None: np.exp(-x),
    "exp_plus": np.exp,
    "alike": lambda number, x: number + np.zeros_like(x),
    "larger": np.fmax,
    "smaller": np.fmin,
    "greatest": np.max,
}


def on_arrays(function: Callable) -> Callable:
    """A function of kernels, or of Python, as one of NumPy arrays; so are the functions of kernels that it calls."""
    plain: Any = getattr(function, "__wrapped__", function)
    names: dict[str, Any] = {}
    for name in plain.__code__.co_names:
        value = plain.__globals__.get(name)
        if value is ti:
            names[name] = LANGUAGE
        elif value is math:
            names[name] = MATHS
        elif name in FUNCTIONS:
            names[name] = FUNCTIONS[name]
        elif of_kernels(value):
            names[name] = on_arrays(value)
    if not names:
        return plain
    return types.FunctionType(plain.__code__, plain.__globals__ | names, plain.__name__, plain.__defaults__)


@functools.cache
def law_on_arrays(law: type) -> type:
    """The class of a law whose constants may be arrays, and whose functions take arrays.

    Parameters
    ----------
    law : a law of `taichi_silo.mpm.laws`.

    Returns
    -------
    A class with the law's constants, which are given by name, properties and functions.

    """
    fields = getattr(law, HIDDEN)

    def begin(self: Any, **constants: Any) -> None:
        known = {name: field.default for name, field in fields.items()} | constants
        wrong = [name for name, value in known.items() if name not in fields or value is dataclasses.MISSING]
        if wrong:
            raise TypeError(f"{law.__name__} has no {wrong[0]}, or needs it")
        for name, value in known.items():
            setattr(self, name, value)

    members: dict[str, Any] = {"__init__": begin, "__doc__": f"{law.__name__} on arrays."}
    for name, value in vars(law).items():
        if isinstance(value, property):
            members[name] = functools.cached_property(on_arrays(value.fget))  # type: ignore[arg-type]
            members[name].__set_name__(None, name)
        elif name not in fields and not name.startswith("_"):
            members[name] = on_arrays(value) if of_kernels(value) or isinstance(value, types.FunctionType) else value
    return type(f"{law.__name__}OnArrays", (), members)
