"""The language of the kernels: Taichi where it is installed, otherwise Quadrants, the fork that carries it on.

Every module takes `ti` from here. The environment variable TAICHI_SILO_LANGUAGE (taichi or quadrants) chooses between
the two where both are installed.
"""

import importlib.util
import os

from taichi_silo.errors import BadInput
from taichi_silo.mpm.front_end import speed_up

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
if NAME == "taichi":
    import taichi as ti
else:
    import quadrants as ti
speed_up(NAME)
VERSION = f"{NAME} {'.'.join(map(str, ti.__version__))}"

__all__ = ["LANGUAGES", "NAME", "VARIABLE", "VERSION", "ti"]
