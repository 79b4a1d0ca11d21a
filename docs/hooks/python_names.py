"""The page of the Python interface: its public names, each with its docstring."""

HEAD = """# Python

```python
import taichi_silo as ts
```

These names are the interface; everything else may change. How to work with them: [Python and notebooks](../how-to/python.md).

"""
GROUPS = (
    ("Functions", ("run", "read_scene", "named_sand")),
    ("Results", ("Result", "Simulation", "Record")),
    ("Scenes", None),
    ("What goes wrong", ("BadInput", "RunFailed")),
)
FIELDS = "\n*Its values with units, ranges and defaults: [scene file](scene.md).*\n"


def page() -> str:
    """The page; names that belong to no group are those of a scene."""
    import taichi_silo
    from taichi_silo.table import Table

    homes = {name: f"taichi_silo.{module}.{name}" for module, names in taichi_silo.HOME.items() for name in names}
    named = {name for _, names in GROUPS if names for name in names}
    lines = [HEAD]
    for title, names in GROUPS:
        lines.append(f"## {title}\n")
        for name in names or sorted(set(homes) - named, key=lambda name: (name != "Scene", name)):
            if name in homes:
                value = getattr(taichi_silo, name)
                fields = FIELDS if isinstance(value, type) and issubclass(value, Table) else ""
                lines.append(f"::: {homes[name]}\n{fields}")
    return "\n".join(lines)
