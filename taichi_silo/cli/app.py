"""The program `taichi-silo`."""

import gc
import importlib
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from taichi_silo.cli.command_line import serve

PLUGIN = "--plugin"
SEARCH_AFTER = 50_000  # new objects, for those that only refer to each other; 700 is usual
COMMANDS = (
    "run",
    "resume",
    "scene",
    "list",
    "render",
    "report",
    "compare",
    "export",
    "gallery",
    "sweep",
    "converge",
    "calibrate",
    "drawing",
    "eurocode",
    "doctor",
)  # in the order of the help


def make(names: Iterable[str] = COMMANDS) -> typer.Typer:
    """The app with these commands."""
    app = typer.Typer(
        name="taichi-silo", no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode="markdown",
        help="Sand flowing in silos: wall pressures, flow pattern, films of the shear zones. All units are SI.",
    )  # fmt: skip
    app.callback()(plugged)
    for name in names:
        module = importlib.import_module(f"taichi_silo.cli.commands.{name}")
        app.command(name, **getattr(module, "OPTIONS", {}))(getattr(module, "command", None) or getattr(module, name))
    return app


def plugged(
    plugin: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE.py", help="run this file, which registers a law, a contact, a field or an observer of your "
            "own; anywhere in the line, repeatable",
        ),
    ] = None,
) -> None:  # fmt: skip
    """Take in the plugins before any command."""
    if plugin:
        from taichi_silo.runs.plugins import load_plugin  # with it comes Taichi

        for file in plugin:
            load_plugin(file)


def plugins_first(words: Sequence[str]) -> list[str]:
    """The words of a command line, with what stands for plugins before the command.

    >>> plugins_first(["run", "silo.toml", "--plugin", "law.py", "--quiet"])
    ['--plugin', 'law.py', 'run', 'silo.toml', '--quiet']
    """
    first: list[str] = []
    rest: list[str] = []
    waiting = False
    for word in words:
        if waiting or word == PLUGIN or word.startswith(f"{PLUGIN}="):
            first.append(word)
        else:
            rest.append(word)
        waiting = word == PLUGIN
    return first + rest


def main() -> None:
    """Run the program, with no more than the command that is asked for: each takes time to make.

    Modules and kernels are hundreds of thousands of objects, all in use: to look for garbage among them every now and
    then takes a twentieth of a short run.
    """
    gc.set_threshold(SEARCH_AFTER)
    words = plugins_first(sys.argv[1:])
    asked = next((word for word in words if word in COMMANDS), None)
    serve(make([asked] if asked else COMMANDS), "taichi-silo", words, of_run=asked == "run")


if __name__ == "__main__":
    main()
