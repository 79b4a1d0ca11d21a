"""A command line that says in one sentence what is wrong: of a scenario script, and of the program."""

import contextlib
import functools
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

import typer

from taichi_silo.errors import BadInput, MachineFailed, RunFailed, Stopped
from taichi_silo.utils import signals, streams
from taichi_silo.utils.bounded_reading import place
from taichi_silo.utils.console import Console
from taichi_silo.utils.machine_faults import of_machine
from taichi_silo.utils.messages import counted
from taichi_silo.utils.messages import sentence as in_one_line

BAD_INPUT, FAILED, STOPPED = 2, 1, 130
LEFT = {  # by a run: what it names at its end
    "void_ratio.mp4": "film", "figures/forces.png": "P, T, N against the bottom displacement",
    "figures/wall_friction_angle.png": "arctan(T/N) against the bottom displacement",
    "figures/void_ratio.png": "shear zones", "figures/wall_stress.png": "wall stresses, beside theory",
    "figures/outflow.png": "what has left by each outlet, and its rate",
    "figures/collapse.png": "surfaces of the column, and its run-out against time", "forces.csv": "force histories",
    "summary.json": "peaks, residuals, certificate", "snapshots/silo.pvd": "for ParaView",
}  # fmt: skip
USAGE_ERROR: Any = typer.BadParameter.__base__  # typer gives it no name of its own


def command(function: Callable, arguments: Sequence[str] | None = None, name: str | None = None) -> NoReturn:
    """Run a function, whose parameters are the flags, as a command line; a name for its help if not the script's.

    Bad input ends with exit code 2, a failed run or machine with 1. The words are the process's if none are given.
    """
    serve(app_of(function), name or Path(sys.argv[0]).name, arguments, of_run=True)


def app_of(function: Callable) -> typer.Typer:
    """The app of one command, whose flags are the function's parameters."""
    from taichi_silo.cli.flags import with_method_flags  # with it come the types of the scene, and Taichi

    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    app.command()(with_method_flags(function))
    return app


def serve(
    app: typer.Typer, name: str, arguments: Sequence[str] | None = None, of_run: bool = False
) -> NoReturn:  # fmt: skip
    """Run an app of a name; it ends the process with the exit code, after one sentence if something is wrong.

    `of_run`: whether its command is one run, of which nothing is left before it hears signals.
    """
    streams.last()
    times = signals.times
    words = list(sys.argv[1:] if arguments is None else arguments)
    for one in app.registered_commands:
        one.callback = one.callback and _stopping(one.callback)
    try:
        code = app(words, standalone_mode=False, prog_name=name)  # what the command returns, or typer's own code
        if code == STOPPED:  # typer's own answer to Ctrl-C
            raise KeyboardInterrupt
        sys.exit(code if isinstance(code, int) else 0)
    except typer.BadParameter as error:
        _stop(_bad_flag(error, words), BAD_INPUT)
    except USAGE_ERROR as error:  # an unknown flag, a flag without its value
        _stop(error.format_message().rstrip("."), BAD_INPUT)
    except BadInput as error:
        _stop(error.on_command_line, BAD_INPUT)
    except MachineFailed as error:
        _stop(str(error), FAILED)
    except RunFailed as error:
        _stop(f"the run went wrong {error}; everything up to then is kept", FAILED)
    except (KeyboardInterrupt, typer.Abort):
        begun = not of_run or signals.times > times
        _stop("stopped; everything up to then is kept" if begun else signals.BEFORE, STOPPED)
    except Exception as error:
        if wrong := _bad_value(error):
            _stop(wrong, BAD_INPUT)
        fault = of_machine(error)
        if fault is None:
            raise
        what, remedy = fault
        _stop(f"{what}; {remedy}, and give the command again", FAILED)


def _stopping(function: Callable) -> Callable:
    """The function; its stop by a signal ends the process here, before typer turns it into a plain interrupt."""

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except Stopped as stop:
            _stop(str(stop), stop.code)

    return call


def _bad_value(error: Exception) -> str:
    """What is wrong with a value of a scene; empty if it is another error."""
    from pydantic import ValidationError  # there already where scenes are

    from taichi_silo.utils.schema import one_sentence

    return one_sentence(error) if isinstance(error, ValidationError) else ""


def _bad_flag(error: typer.BadParameter, arguments: Sequence[str]) -> str:
    flag = error.param.opts[0] if error.param is not None else "a flag"
    if not flag.startswith("-"):  # an argument: the message names its value
        message = error.message.removeprefix("Value error, ").rstrip(".")
        return f"{flag}: {message or 'not given; see --help'}"
    words = " ".join(arguments).replace(f"{flag}=", f"{flag} ").split()
    given = words[words.index(flag) + 1] if flag in words[:-1] else "not given"
    message = error.message.removeprefix("Value error, ")
    return f"{flag} is {given}; {message[:1].lower()}{message[1:].rstrip('.')}"


def _stop(sentence: str, code: int) -> NoReturn:
    sentence = in_one_line(sentence)
    print(f"Error: {sentence}{'' if sentence.endswith('?') else '.'}", file=sys.stderr)
    sys.exit(code)


def print_or_write(text: str, output: Path | None) -> None:
    """Print a text, or write it to a file that is not there yet.

    Raises BadInput if the file is there, or cannot be written.
    """
    if output is None:
        _print_file(text)
        return
    output = place(output, "output")
    if output.exists():
        raise BadInput(f"output {output} is there already; give another name")
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"output {output} cannot be written: {error.strerror or error}") from error


def _print_file(text: str) -> None:
    """Print the text of a file: where no person reads it, in UTF-8, whatever the machine's code page."""
    stream: Any = sys.stdout
    if not stream.isatty():
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(encoding="utf-8")
    print(text, end="")
    streams.heard()


def explain(scene, flag_words: Callable[[str], str] = str) -> None:
    """Say which parts of the method a scene uses, and why; the words for flags as another function has them."""
    from rich import box
    from rich.console import Console as RichConsole
    from rich.table import Table

    from taichi_silo.runs.method_choices import parts  # with it comes the whole solver

    scene.machine.start()
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in ("part", "choice", "because", "otherwise by"):
        table.add_column(column)
    for part in parts(scene):
        table.add_row(part.part, part.choice, part.because, flag_words(part.flag) or "–")
    RichConsole(width=None if sys.stdout.isatty() else 132, highlight=False).print(table)


def check(scene, name: str, console: Console) -> None:
    """Say that a scene is possible, and what it will cost."""
    from taichi_silo.runs import cost_estimate
    from taichi_silo.scene import known_limits, likely_units

    points = counted(scene.points, "point")
    console.say(f"{name} is a possible scene: {points}, {scene.weight_N_per_m:.4g} N/m of sand")
    for sentence in (*known_limits.of_method(scene), *likely_units.of_scene(scene)):
        console.say(f"Warning: {sentence}")
    cost = cost_estimate.before_start(scene)
    console.say(cost.words())
    told = {"points": scene.points, "steps": cost.steps, "seconds": cost.seconds}
    console.result({"scene": scene.model_dump(mode="json")} | told)


def tell(folder: Path, console: Console | None = None) -> None:
    """Say where to look, and how far to trust it."""
    from taichi_silo.runs.result import Result
    from taichi_silo.runs.run_folder import typed
    from taichi_silo.show.report.trust import verdict

    console = console or Console()
    console.say(f"\nThe run is in {folder}")
    there = {name: what for name, what in LEFT.items() if (folder / name).exists()}
    for name, what in there.items():
        console.say(f"  {name:{max(map(len, there))}s}  {what}")
    run = Result(folder, tolerant=True)
    said = verdict(run)
    console.say(f"\n{said.title}. {said.words}", f"One page of it all: taichi-silo report {typed(folder)}")
    console.result({"folder": str(folder), "summary": run.summary})
