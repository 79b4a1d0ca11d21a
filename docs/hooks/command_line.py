"""The command line in words: every command and every scenario with its flags, as typer has them."""

import re
import typing

from typer.main import get_command

KINDS = {"str": "text", "Path": "path", "float": "number", "int": "whole number", "bool": ""}
CALL = re.compile(r"taichi-silo [^\n]*?(?=,\s*taichi-silo |$)")


def commands() -> str:
    """All commands."""
    from taichi_silo.cli import app, command_line
    from taichi_silo.cli.commands.run import scene_file

    found = dict(get_command(app.make()).commands) | {"run": get_command(command_line.app_of(scene_file))}
    return "\n".join(section(f"taichi-silo {name}", found[name], found[name].help) for name in app.COMMANDS)


def scenarios() -> str:
    """All scenarios; the flags that belong to a silo's run once, before them."""
    from taichi_silo.cli import catalogue, command_line
    from taichi_silo.cli.scenario import CONTROLLED, shared_names

    shared, known, found = set(shared_names(CONTROLLED)), catalogue.scenarios(), []
    for name in known:
        command = get_command(command_line.app_of(catalogue.load(name)))
        of_silo = any(one.name == "explain" for one in command.params)
        if name == "mass_flow":
            found.insert(0, table([one for one in command.params if one.name in shared]))
        words = catalogue.about(name)
        found.append(section(name, command, words, f"taichi-silo run {name}", shared if of_silo else ()))
    return "\n".join(found)


def section(title: str, command, words: str, call: str = "", hidden=()) -> str:
    """One command: what it does, how it is called, its flags."""
    shown = [one for one in command.params if one.name not in hidden and one.name != "help"]
    arguments = [names_of(one)[0] for one in shown if one.param_type_name == "argument"]
    usage = " ".join([call or title, *arguments, "[FLAGS]"])
    lines = [f"## {title}\n", paragraphs(words), f"```text\n{usage}\n```\n", table(shown) if shown else ""]
    if hidden:
        lines.append("and the [shared flags](#shared-flags).\n")
    return "\n".join(lines)


def table(flags: list) -> str:
    """Flags and arguments."""
    rows = ["| flag | value | default | meaning |", "|---|---|---|---|"]
    for one in flags:
        names = ", ".join(f"`{name}`{{ .flag }}" for name in names_of(one))
        taken = one.type_descriptor.annotation
        choices = typing.get_args(taken) if typing.get_origin(taken) is typing.Literal else ()
        kind = " | ".join(choices) or KINDS[(typing.get_args(taken) or (taken,))[0].__name__]
        kind += ", repeatable" if one.multiple or one.nargs < 0 else ""
        cells = (names, kind, default_of(one), " ".join((one.help or "").split()))
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows) + "\n"


def names_of(one) -> list[str]:
    """What is typed for it."""
    if one.param_type_name == "argument":
        return [one.metavar or one.name.upper()]
    return [*one.opts, *one.secondary_opts]


def default_of(one) -> str:
    """What holds without a flag."""
    if one.required:
        return "must be given"
    if one.default is True:
        return f"`{one.opts[0]}`"
    return "" if one.default is None or one.default is False else f"`{one.default}`"


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
