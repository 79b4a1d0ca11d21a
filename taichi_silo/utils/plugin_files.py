"""Files and installed packages of users that register parts of their own: they are imported, and so run."""

import importlib.util
import sys
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from taichi_silo.errors import BadInput
from taichi_silo.utils.bounded_reading import place

GROUP = "taichi_silo.plugins"  # entry points of installed packages
_loaded: dict[Path, ModuleType] = {}
_looked = False  # whether the installed packages were loaded


def load(file: str | Path) -> ModuleType:
    """The module of a Python file, which is run once in a process.

    Raises
    ------
    BadInput
        if there is no such file, or it cannot be run.

    """
    where = place(file, "plugin").resolve()
    if where in _loaded:
        return _loaded[where]
    if where.suffix != ".py" or not where.is_file():
        raise BadInput(f"plugin is {file}; it must be a Python file, such as my_law.py, and be there")
    name = f"taichi_silo_plugin_{len(_loaded)}_{where.stem}"
    spec = importlib.util.spec_from_file_location(name, where)
    assert spec is not None and spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        if isinstance(error, BadInput):
            raise BadInput(f"plugin {file}: {error}") from error
        raise BadInput(f"plugin {file} cannot be run: {type(error).__name__}: {error}") from error
    _loaded[where] = module
    return module


def loaded() -> list[str]:
    """The files that this process has loaded, for another one that is to load them too."""
    return [str(file) for file in _loaded]


def installed() -> None:
    """Load the installed packages that have an entry point in the group `taichi_silo.plugins`, once in a process.

    Raises
    ------
    BadInput
        if one cannot be loaded.

    """
    global _looked  # noqa: PLW0603 - once in a process
    if _looked:
        return
    _looked = True
    for entry in entry_points(group=GROUP):
        try:
            entry.load()
        except Exception as error:
            raise BadInput(f"the installed plugin {entry.name} cannot be run: {error}") from error
