"""Every value of a scene file: type, unit, range, default and meaning, from the types themselves."""

import enum
import re
import types
import typing
from dataclasses import dataclass

import tomli_w

from taichi_silo.scene.scene import Scene
from taichi_silo.utils.schema import Options, table_in

UNITS = {
    "kg_per_m3": "kg/m³", "m_per_s2": "m/s²", "m_per_s": "m/s", "m2": "m²", "deg": "°", "Pa": "Pa", "m": "m", "s": "s",
}  # fmt: skip
SAND_ITSELF = ("name", "void_ratio", "law")  # of a sand, beside its constants
SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}


@dataclass(frozen=True)
class Entry:
    """One value.

    Attributes
    ----------
    path : dotted; `silo.inserts[].kind` of each entry of a list of tables.
    kind : words for its type, with the choices.
    unit : empty if it has none.
    limits : such as "> 0, ≤ 5"; empty if there are none.
    default : None if it is absent, `REQUIRED` if it must be given.
    meaning : what it is.
    optional : the table it stands in may be absent, and is by default.

    """

    path: str
    kind: str
    unit: str
    limits: str
    default: object
    meaning: str
    optional: bool

    @property
    def default_words(self) -> str:
        """As TOML writes it."""
        if self.default is REQUIRED:
            return "must be given"
        return "absent" if self.default is None else written(self.default)


class _Required(enum.Enum):
    REQUIRED = "required"


REQUIRED = _Required.REQUIRED


def entries(table: type[Options] = Scene, before: str = "", optional: bool = False) -> list[Entry]:
    """All values of a table, in its order; those of its own tables last."""
    values, tables = [], []
    for name, field in table.model_fields.items():
        inner = table_in(field.annotation)
        path = f"{before}{name}"
        if inner is not None:
            many = typing.get_origin(field.annotation) is tuple
            absent = optional or many or type(None) in typing.get_args(field.annotation)
            tables += entries(inner, f"{path}{'[]' if many else ''}.", absent)
            continue
        unit = next((UNITS[end] for end in UNITS if name.endswith(f"_{end}")), "")
        rules = [(SIGNS[key], getattr(rule, key)) for key in SIGNS for rule in field.metadata if hasattr(rule, key)]
        limits = ", ".join(f"{sign} {limit:g}" for sign, limit in rules)
        default = REQUIRED if field.is_required() else field.get_default(call_default_factory=True)
        meaning = " ".join((field.description or "").split())
        values.append(Entry(path, _kind(field.annotation), unit, limits, default, meaning, optional))
    return values + tables


def tables_of(table: type[Options] = Scene, before: str = "") -> dict[str, str]:
    """Names of the tables, and what each is."""
    found = {}
    for name, field in table.model_fields.items():
        inner = table_in(field.annotation)
        if inner is not None:
            many = typing.get_origin(field.annotation) is tuple
            path = f"{before}{name}{'[]' if many else ''}"
            found[path] = " ".join(re.split(r"\n\s*\n", inner.__doc__)[0].split())
            found |= tables_of(inner, f"{path}.")
    return found


def template() -> str:
    """A scene file with every value at its default, and what it means."""
    lines = ["# A silo for taichi-silo: every value with its default. What is left out takes it."]
    for table, found in _by_table().items():
        optional = "# " if found[0].optional else ""
        lines += ["", f"# {tables_of()[table]}", f"{optional}{_header(table)}"]
        for entry in found:
            name, given = entry.path.rpartition(".")[2], entry.default not in (None, REQUIRED)
            named = table == "sand" and name not in SAND_ITSELF  # a constant follows from the sand's name
            about = (f"[{entry.unit}]" if entry.unit else "", entry.kind, entry.limits, entry.meaning)
            value = written(entry.default) if given else "..."
            off = optional if given and not named else "# "
            lines.append(f"{off}{name} = {value}  # {'; '.join(filter(None, about))}")
    return "\n".join(lines) + "\n"


def markdown() -> str:
    """The same as tables of a page."""
    lines = []
    for table, found in _by_table().items():
        lines += ["", f"## `{_header(table)}`", "", tables_of()[table], ""]
        lines += ["| name | type | unit | range | default | meaning |", "|---|---|---|---|---|---|"]
        for entry in found:
            default = entry.default_words if entry.default in (None, REQUIRED) else f"`{entry.default_words}`"
            cells = (f"`{entry.path.rpartition('.')[2]}`", entry.kind, entry.unit, entry.limits, default, entry.meaning)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines).strip() + "\n"


def _by_table() -> dict[str, list[Entry]]:
    found = {}
    for entry in entries():
        found.setdefault(entry.path.rpartition(".")[0], []).append(entry)
    return found


def _header(table: str) -> str:
    return f"[[{table.removesuffix('[]')}]]" if table.endswith("[]") else f"[{table}]"


def written(value) -> str:
    """A value as TOML writes it."""
    return tomli_w.dumps({"v": value}).removeprefix("v = ").strip()


def _kind(annotation) -> str:
    """Words for a type."""
    arguments = [part for part in typing.get_args(annotation) if part is not type(None)]
    origin = typing.get_origin(annotation)
    if origin is typing.Literal:
        return " | ".join(f'"{choice}"' for choice in arguments)
    if origin in (typing.Union, types.UnionType):
        return " | ".join(map(_kind, arguments))
    if origin is tuple:
        return "list of pairs of numbers" if typing.get_origin(arguments[0]) is tuple else "list"
    if origin is typing.Annotated:
        return _kind(arguments[0])
    return {"float": "number", "int": "whole number", "str": "text", "bool": "true | false"}[annotation.__name__]
