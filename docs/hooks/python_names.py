"""The Python interface: its public names, each with its docstring."""

import inspect

FIELDS = "\n*Its values with units, ranges and defaults: [scene file](scene.md).*\n"


def names() -> str:
    """All of them, by what they are."""
    import taichi_silo
    from taichi_silo.utils.schema import Options

    kinds = {"Functions": [], "Results": [], "Scenes": [], "What goes wrong": []}
    for module, found in taichi_silo.HOME.items():
        for name in found:
            value, place = getattr(taichi_silo, name), f"::: taichi_silo.{module}.{name}\n"
            if not inspect.isclass(value):
                kinds["Functions"].append(place)
            elif issubclass(value, BaseException):
                kinds["What goes wrong"].append(place)
            elif issubclass(value, Options):
                kinds["Scenes"].append(place + FIELDS)
            else:
                kinds["Results"].append(place)
    return "\n".join(f"## {kind}\n\n" + "\n".join(places) for kind, places in kinds.items() if places)
