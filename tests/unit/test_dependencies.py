"""What the package imports is what pyproject.toml asks for: nothing less, and nothing more."""

import ast
import sys
from pathlib import Path

from checks.lock import ROOT, declared

PACKAGE = ROOT / "taichi_silo"
NAMES = {"PIL": "pillow", "tomli_w": "tomli-w", "dask_jobqueue": "dask-jobqueue"}
BROUGHT = {  # by what is built on them
    "imageio_ffmpeg": "imageio", "dask": "distributed", "pydantic_core": "pydantic", "markupsafe": "jinja2",
}  # fmt: skip
OPTIONAL = ("cluster", "drawings")  # parts that a user may leave out


def imports(file: Path, at_once: bool = False) -> set[str]:
    """Dotted names that a file imports; `at_once`: when it is imported itself, not first when a function is called."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)] if at_once else []
    later = {inner for node in functions for inner in ast.walk(node)}
    found = set()
    for node in set(ast.walk(tree)) - later:
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module, *(f"{node.module}.{name.name}" for name in node.names)}
    return found


def packages(names: set[str]) -> set[str]:
    """Packages of other people that bring modules with these names."""
    tops = {name.split(".")[0] for name in names} - sys.stdlib_module_names - {"taichi_silo"}
    brought = {BROUGHT.get(name, name) for name in tops}
    return {NAMES.get(name, name) for name in brought}


def test_everything_imported_is_asked_for_and_everything_asked_for_is_imported():
    parts = declared()
    wanted = set(parts["core"]).union(*(parts[part] for part in OPTIONAL))
    files = [*PACKAGE.rglob("*.py"), *(ROOT / "scenarios").glob("*.py")]
    assert packages(set().union(*map(imports, files))) == wanted


def test_the_program_starts_without_what_a_user_may_leave_out():
    """Modules that need it are imported by a function that begins a sweep, and nowhere else."""
    optional = {name for part in OPTIONAL for name in declared()[part]}
    at_once = {
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): imports(file, at_once=True)
        for file in PACKAGE.rglob("*.py")
    }
    need = {module for module, names in at_once.items() if packages(names) & optional}
    while more := {module for module, names in at_once.items() if names & need} - need:
        need |= more
    assert not need
