"""The scenario scripts, wherever the package is installed: beside it in a checkout, inside it elsewhere."""

import ast
from pathlib import Path

from taichi_silo.errors import BadInput
from taichi_silo.utils.messages import near, shown

PACKAGE = Path(__file__).parents[1]


def folder() -> Path:
    """Where the scripts are."""
    inside = PACKAGE / "scenarios"
    return inside if inside.is_dir() else PACKAGE.parent / "scenarios"


def scenarios() -> dict[str, str]:
    """Their names, and what each does in a sentence."""
    found = {}
    for file in sorted(folder().glob("*.py")):
        words = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        if not file.stem.startswith("_"):
            found[file.stem] = " ".join(words.split("\n\n")[0].split())
    return found


def script(name: str) -> Path:
    """The script of a scenario.

    Raises
    ------
    BadInput
        if there is none of this name.

    """
    known = {file.stem: file for file in folder().glob("*.py")}
    wanted = name.replace("-", "_")
    if wanted not in known:
        meant = near(wanted, known)
        hint = f"did you mean {meant}" if meant else f"the scenarios are {', '.join(sorted(known))}"
        raise BadInput(f"scenario is {shown(name)}; it must be a TOML file or a scenario: {hint}")
    return known[wanted]
