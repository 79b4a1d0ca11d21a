"""The scenario scripts: beside the package in a checkout, inside it where it is installed.

Each says in its docstring what it shows, and holds a function `scenario`, whose parameters are its flags.
"""

import ast
import importlib.util
from collections.abc import Callable
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.utils.messages import near, shown

PACKAGE = Path(__file__).parents[1]


def folder() -> Path:
    """The folder of the scripts."""
    inside = PACKAGE / "scenarios"
    return inside if inside.is_dir() else PACKAGE.parent / "scenarios"


def scenarios() -> dict[str, str]:
    """Names of all scenarios, and what each shows in a sentence."""
    names = sorted(file.stem for file in folder().glob("*.py"))
    return {name: " ".join(about(name).split("\n\n")[0].split()) for name in names}


def about(name: str) -> str:
    """What a scenario's script says of it; the script is read, not run."""
    return ast.get_docstring(ast.parse(script(name).read_text(encoding="utf-8"))) or ""


def load(name: str) -> Callable:
    """The function of a scenario, imported from its script.

    Raises BadInput if there is no scenario of this name.
    """
    file = script(name)
    spec = importlib.util.spec_from_file_location(f"scenario_{file.stem}", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.scenario


def script(name: str) -> Path:
    """The script of a scenario.

    Raises BadInput if there is none of this name.
    """
    known = {file.stem: file for file in folder().glob("*.py")}
    wanted = name.replace("-", "_")
    if wanted not in known:
        meant = near(wanted, known)
        hint = f"did you mean {meant}?" if meant else f"the scenarios are {', '.join(sorted(known))}"
        raise BadInput(f"scenario is {shown(name)}; it must be a TOML file or a scenario: {hint}")
    return known[wanted]
