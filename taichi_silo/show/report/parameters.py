"""Every parameter of a run with its unit and meaning, from `run.toml` and the scene's own descriptions."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from taichi_silo.scene import reference

TITLES = {
    "silo": "Silo", "sand": "Sand", "walls": "Walls", "grid": "Grid and points", "averaging": "Non-local average",
    "filling": "Filling", "flow": "Flow", "method": "Method", "eurocode": "EN 1991-4",
    "output": "Output", "machine": "Machine",
    "program": "Program",
}  # fmt: skip
PROGRAM = {  # what no scene has
    "program.taichi_silo": "version",
    "program.revision": "of the source",
    "program.plugins": "files of the user's own parts",
    "program.taichi": "version",
    "program.quadrants": "version",
    "program.python": "version",
    "program.precision": "of all numbers",
    "program.wall_seconds": "of the whole run, films and files included",
    "program.finished": "whether the run came to its end",
    "program.resumed": "how often it was gone on with after a break",
}


@dataclass(frozen=True)
class Parameter:
    """A parameter: dotted path in its table, value as in `run.toml`, unit, meaning."""

    name: str
    value: str
    unit: str
    means: str


def parameter_tables(parameters: dict) -> list[tuple[str, list[Parameter]]]:
    """Title and parameters of each table of a `run.toml`, in the order of the file's own kind."""
    names = [name for name in TITLES if name in parameters]
    names += [name for name in parameters if name not in TITLES]
    entries = {entry.path: (entry.unit, entry.meaning) for entry in reference.entries()}
    known = {path: ("", words) for path, words in (PROGRAM | reference.tables_of()).items()} | entries
    tables = []
    for name in names:
        rows = []
        for path, value in _flat(name, parameters[name]):
            own = re.sub(r"\.\d+(?=\.|$)", ".0", path)  # which stands for each entry of a list
            unit, means = known.get(own) or known.get(f"{own}.0") or ("", "")
            rows.append(Parameter(path.removeprefix(f"{name}."), _words(value), unit, means))
        tables.append((TITLES.get(name, name), rows))
    return tables


def _flat(path: str, value) -> Iterator[tuple[str, object]]:
    """Dotted paths and values below a path; tables in a list are numbered from 1."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        value = dict(enumerate(value, 1))
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _flat(f"{path}.{name}", inner)
    else:
        yield path, value


def _words(value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(map(_words, value)) or "none"
    if isinstance(value, float):
        return repr(value).removesuffix(".0")
    return str(value)
