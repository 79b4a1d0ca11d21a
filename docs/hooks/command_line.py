"""The command line in words: every command and every scenario with its flags, from the program's own functions."""

import ast
import importlib
import inspect
import re
import types
import typing
from dataclasses import dataclass

import typer

KINDS = {"str": "text", "Path": "path", "float": "number", "int": "whole number", "bool": ""}
CALL = re.compile(r"taichi-silo [^\n]*?(?=,\s*taichi-silo |$)")


@dataclass(frozen=True)
class Flag:
    """One flag, or one argument.

    Attributes
    ----------
    name : of the function's parameter.
    words : as it is written on the command line.
    kind : what it takes.
    default : what holds without it.
    help : what it means.
    argument : whether it stands without a name.

    """

    name: str
    words: str
    kind: str
    default: str
    help: str
    argument: bool


def commands() -> str:
    """All commands."""
    from taichi_silo.cli import app
    from taichi_silo.cli.commands.run import scene_file

    found = []
    for name in app.COMMANDS:
        module = importlib.import_module(f"taichi_silo.cli.commands.{name}")
        function = getattr(module, "command", None) or getattr(module, name)
        found.append(section(f"taichi-silo {name}", scene_file if name == "run" else function))
    return "\n".join(found)


def scenarios() -> str:
    """All scenarios; the flags that belong to a silo's run once, before them."""
    from taichi_silo.cli import catalogue
    from taichi_silo.cli.flags import GROUPS
    from taichi_silo.cli.scenario_flags import Controlled, Free

    functions = {name: of_scenario(catalogue.script(name)) for name in catalogue.scenarios()}
    shared = set(GROUPS[Controlled].flags)
    found = [table([flag for flag in flags_of(functions["mass_flow"]) if flag.name in shared])]
    for name, function in functions.items():
        kinds = {parameter.annotation for parameter in inspect.signature(function).parameters.values()}
        hidden = shared if kinds & {Controlled, Free} else frozenset()
        found.append(section(name, function, f"taichi-silo run {name}", hidden))
    return "\n".join(found)


def of_scenario(file):
    """The function of a scenario's script."""
    code = file.read_text(encoding="utf-8")
    known = {"__name__": f"scenario_{file.stem}", "__file__": str(file)}
    exec(compile(code, str(file), "exec"), known)
    called = [
        node.args[0].id
        for node in ast.walk(ast.parse(code))
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "command" and node.args
    ]
    function = known[called[-1]]
    function.__doc__ = known["__doc__"]  # of the script, which says more
    return function


def flags_of(function) -> list[Flag]:
    """Flags and arguments of a function, groups spread."""
    from taichi_silo.cli.flags import with_groups

    found = []
    for name, parameter in inspect.signature(with_groups(function)).parameters.items():
        if parameter.annotation is typer.Context:
            continue
        kind, info = parameter.annotation, None
        if typing.get_origin(kind) is typing.Annotated:
            kind, *notes = typing.get_args(kind)
            infos = [note for note in notes if isinstance(note, (typer.models.OptionInfo, typer.models.ArgumentInfo))]
            info = infos[-1] if infos else None
        argument = isinstance(info, typer.models.ArgumentInfo)
        given = (getattr(info, "default", None), *(getattr(info, "param_decls", None) or ()))  # names, if any
        names = [one for one in given if isinstance(one, str) and one.startswith("-")] or [usual(name, kind)]
        words = (info.metavar or name.upper()) if argument else ", ".join(names).replace("/", ", ")
        help = " ".join((getattr(info, "help", None) or "").split())
        found.append(Flag(name, words, words_of(kind), default_of(parameter, words), help, argument))
    return found


def usual(name: str, kind) -> str:
    """A flag's name where the function gives none."""
    flag = name.replace("_", "-")
    return f"--{flag}, --no-{flag}" if bool in (kind, *typing.get_args(kind)) else f"--{flag}"


def words_of(kind) -> str:
    """What a flag takes, in words."""
    origin, inner = typing.get_origin(kind), [one for one in typing.get_args(kind) if one is not type(None)]
    if origin in (typing.Union, types.UnionType):
        return words_of(inner[0])
    if origin is typing.Literal:
        return " \\| ".join(map(str, inner))
    if origin is list:
        return f"{words_of(inner[0])}, repeatable"
    return KINDS[kind.__name__]


def default_of(parameter: inspect.Parameter, words: str) -> str:
    """What holds without a flag."""
    value = parameter.default
    if value is inspect.Parameter.empty:
        return "must be given"
    if value is None or value is False:
        return ""
    return f"`{words.split(',')[0]}`" if value is True else f"`{value}`"


def section(title: str, function, call: str = "", hidden=frozenset()) -> str:
    """One command: what it does, how it is called, its flags."""
    shown = [flag for flag in flags_of(function) if flag.name not in hidden]
    usage = " ".join([call or title, *(flag.words for flag in shown if flag.argument), "[FLAGS]"])
    lines = [f"## {title}\n", paragraphs(function.__doc__), f"```text\n{usage}\n```\n", table(shown) if shown else ""]
    if hidden:
        lines.append("and the [shared flags](#shared-flags).\n")
    return "\n".join(lines)


def paragraphs(text: str) -> str:
    """A docstring in Markdown: examples are set off as code."""
    found = []
    for part in re.split(r"\n\s*\n", text.strip()):
        lines = [line.strip() for line in part.splitlines()]
        if all(line.startswith("taichi-silo ") for line in lines):
            found.append(code(lines))
            continue
        head, *examples = re.split(r"\bExamples?:", " ".join(lines), maxsplit=1)
        calls = CALL.findall(examples[0].strip()) if examples else []
        found += [one for one in (head.strip(), code(calls) if calls else "") if one]
    return "\n\n".join(found).replace("\n```\n\n```console\n", "\n") + "\n"


def code(lines: list[str]) -> str:
    """Lines as they are typed."""
    return "```console\n" + "\n".join(line.rstrip(" ,.") for line in lines) + "\n```"


def table(flags: list[Flag]) -> str:
    """Flags and arguments."""
    rows = ["| flag | value | default | meaning |", "|---|---|---|---|"]
    for flag in flags:
        names = ", ".join(f"`{name.strip()}`{{ .flag }}" for name in flag.words.split(","))
        rows.append(f"| {names} | {flag.kind} | {flag.default} | {flag.help.replace('|', chr(92) + '|')} |")
    return "\n".join(rows) + "\n"
