"""Every value of a scene file: type, unit, range, default and meaning, from the types themselves."""

import enum
import re
import types
import typing
from dataclasses import dataclass
from typing import Any

import tomli_w

from taichi_silo.scene.dotted_paths import Place, places

UNITS = {
    "N_per_m3": "N/m³", "kg_per_m3": "kg/m³", "m_per_s2": "m/s²", "m_per_s": "m/s", "m2": "m²", "deg": "°", "Pa": "Pa",
    "m": "m", "s": "s",
}  # fmt: skip
SAND_ITSELF = ("name", "void_ratio", "law")  # of a sand, beside its constants
SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
WORDS = {"float": "number", "int": "whole number", "str": "text", "bool": "true | false"}


class _Required(enum.Enum):
    REQUIRED = "required"


REQUIRED = _Required.REQUIRED


@dataclass(frozen=True)
class Entry:
    """One value."""

    path: str  # dotted; `silo.inserts.0.kind` stands for each entry of a list of tables
    choices: tuple[str, ...]  # the words that it may be; empty if it is no choice
    kind: str  # words for its type, with the choices
    unit: str  # empty if it has none
    limits: str  # such as "> 0, ≤ 5"; empty if there are none
    default: Any  # None if it is absent, `REQUIRED` if it must be given
    meaning: str
    optional: bool  # the table it stands in may be absent, and is by default

    @classmethod
    def of(cls, place: Place) -> "Entry":
        """The entry of one place of the scene."""
        field = place.field
        rules = [(SIGNS[key], getattr(rule, key)) for key in SIGNS for rule in field.metadata if hasattr(rule, key)]
        return cls(
            path=place.path, choices=_choices(field.annotation), kind=_kind(field.annotation),
            unit=next((UNITS[end] for end in UNITS if place.path.endswith(f"_{end}")), ""),
            limits=", ".join(f"{sign} {limit:g}" for sign, limit in rules),
            default=REQUIRED if field.is_required() else field.get_default(call_default_factory=True),
            meaning=" ".join((field.description or "").split()), optional=place.optional,
        )  # fmt: skip

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition(".")[2]

    @property
    def given(self) -> bool:
        """Whether there is a default."""
        return self.default is not None and self.default is not REQUIRED


def entries() -> list[Entry]:
    """All values of a scene, table after table."""
    return [Entry.of(place) for place in places() if place.table is None]


def tables_of() -> dict[str, str]:
    """Paths of the tables, and what each is."""
    return {
        place.path: " ".join(re.split(r"\n\s*\n", place.table.__doc__ or "")[0].split())
        for place in places() if place.table is not None
    }  # fmt: skip


def template() -> str:
    """A scene file with every value at its default, and what it means."""
    lines = ["# A silo for taichi-silo: every value with its default. What is left out takes it."]
    for table, found in _by_table().items():
        optional = "# " if found[0].optional else ""
        lines += ["", f"# {tables_of()[table]}", f"{optional}{_header(table)}"]
        for entry in found:
            named = table == "sand" and entry.name not in SAND_ITSELF  # a constant follows from the sand's name
            about = (f"[{entry.unit}]" if entry.unit else "", entry.kind, entry.limits, entry.meaning)
            value = written(entry.default) if entry.given else "..."
            off = optional if entry.given and not named else "# "
            lines.append(f"{off}{entry.name} = {value}  # {'; '.join(filter(None, about))}")
    return "\n".join(lines) + "\n"


def markdown() -> str:
    """Every value of a scene file, table after table, in Markdown: lists, which a phone shows as they are."""
    lines = []
    for table, found in _by_table().items():
        lines += ["", f"## `{_header(table)}`", "", tables_of()[table], ""]
        for entry in found:
            absent = "must be given" if entry.default is REQUIRED else "absent by default"
            default = f"default `{written(entry.default)}`" if entry.given else absent
            about = ", ".join(filter(None, (entry.kind, entry.unit, entry.limits, default)))
            lines.append(f"- **`{entry.name}`** ({about}): {entry.meaning}")
    return "\n".join(lines).strip() + "\n"


def _by_table() -> dict[str, list[Entry]]:
    found: dict[str, list[Entry]] = {}
    for entry in entries():
        found.setdefault(entry.path.rpartition(".")[0], []).append(entry)
    return found


def _header(table: str) -> str:
    return f"[[{table.removesuffix('.0')}]]" if table.endswith(".0") else f"[{table}]"


def written(value: Any) -> str:
    """A value as TOML writes it."""
    return tomli_w.dumps({"v": value}).removeprefix("v = ").strip()


def _choices(annotation: Any) -> tuple[str, ...]:
    if typing.get_origin(annotation) is typing.Literal:
        return typing.get_args(annotation)
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        return tuple(choice for part in typing.get_args(annotation) for choice in _choices(part))
    return ()


def _kind(annotation: Any) -> str:
    """Words for a type."""
    arguments = [part for part in typing.get_args(annotation) if part is not type(None)]
    origin = typing.get_origin(annotation)
    if origin is typing.Literal:
        return " | ".join(f'"{choice}"' for choice in arguments)
    if origin in (typing.Union, types.UnionType):
        return " | ".join(map(_kind, arguments))
    if origin is tuple:
        return "list of pairs of numbers" if typing.get_origin(arguments[0]) is tuple else "list"
    if origin is dict:
        return "table of numbers"
    if origin is typing.Annotated:
        return _kind(arguments[0])
    return WORDS[annotation.__name__]
