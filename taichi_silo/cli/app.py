"""The program `taichi-silo`."""

import importlib

import typer

from taichi_silo.cli.command_line import serve

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


def make() -> typer.Typer:
    """The app with all commands."""
    app = typer.Typer(
        name="taichi-silo", no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode="markdown",
        help="Sand flowing in silos: wall pressures, flow pattern, films of the shear zones. All units are SI.",
    )  # fmt: skip
    for name in COMMANDS:
        module = importlib.import_module(f"taichi_silo.cli.commands.{name}")
        app.command(name, **getattr(module, "OPTIONS", {}))(getattr(module, "command", None) or getattr(module, name))
    return app


def main() -> None:
    """Run the program."""
    serve(make(), "taichi-silo")


if __name__ == "__main__":
    main()
