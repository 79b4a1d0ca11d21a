"""The language of the kernels: Taichi where it is installed, otherwise Quadrants, the fork that carries it on.

Every module takes `ti` from here. The environment variable TAICHI_SILO_LANGUAGE (taichi or quadrants) chooses between
the two where both are installed.
"""

import importlib.util
import os
from typing import Any

from taichi_silo.errors import BadInput
from taichi_silo.mpm.front_end import frames_by_file, speed_up

LANGUAGES = ("taichi", "quadrants")
VARIABLE = "TAICHI_SILO_LANGUAGE"


def _chosen() -> str:
    """The package that brings the language.

    Raises
    ------
    BadInput
        if the environment names none of the two or one that is not installed, or if none is.

    """
    asked = os.environ.get(VARIABLE)
    if asked and asked not in LANGUAGES:
        raise BadInput(f"{VARIABLE} is {asked!r}; it must be {' or '.join(LANGUAGES)}")
    wanted = (asked,) if asked else LANGUAGES
    found = [name for name in wanted if importlib.util.find_spec(name)]
    if not found:
        raise BadInput(f"{' or '.join(wanted)} must be installed" + (f", as {VARIABLE} asks for it" if asked else ""))
    return found[0]


NAME = _chosen()
with frames_by_file():
    if NAME == "taichi":
        import taichi as ti
    else:
        import quadrants as ti
speed_up(NAME)
VERSION = f"{NAME} {'.'.join(map(str, ti.__version__))}"


def program() -> Any:
    """The running program of the language; None before it was started."""
    known = vars(ti.lang.impl.get_runtime())
    return known["_prog" if "_prog" in known else "prog"]


def of_kernels(function: Any) -> bool:
    """Whether it is a function of kernels: of Taichi's a function, of Quadrants' an object that can be called."""
    return callable(function) and hasattr(function, "__wrapped__")


__all__ = ["LANGUAGES", "NAME", "VARIABLE", "VERSION", "of_kernels", "program", "ti"]
