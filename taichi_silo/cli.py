"""What the scenario scripts share: a command line that says in one sentence what is wrong."""

import functools
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from pydantic import ValidationError
from rich import box
from rich.console import Console
from rich.table import Table

from taichi_silo.faults import BadInput, RunFailed
from taichi_silo.parts import parts
from taichi_silo.scene import Scene
from taichi_silo.shapes import SHAPES
from taichi_silo.table import one_sentence
from taichi_silo.transfers import TRANSFERS

BAD_INPUT, FAILED, STOPPED = 2, 1, 130

# flags that several scenarios share
SandFlag = Annotated[
    str,
    typer.Option(
        help="name of a published sand (karlsruhe, karlsruhe-herle, karlsruhe-fine, hochstetten, hostun, hamburg, "
        "toyoura), or a TOML file with one's own"
    ),
]
LawFlag = Annotated[
    str,
    typer.Option(help="auto | gudehus-bauer | intergranular (with memory; auto: where strain turns back)"),
]
LengthFlag = Annotated[
    float | None,
    typer.Option(help="characteristic length l_c of the non-local law [m]; 3 d50 if not given, 0 for a local law"),
]
WeightFlag = Annotated[
    str, typer.Option(help="of the non-local average: gaussian | exponential (as printed in the paper)")
]
ShapeFlag = Annotated[str, typer.Option(help="shape functions: " + " | ".join(SHAPES))]
HalfFlag = Annotated[str, typer.Option(help="auto | yes | no: compute one half of a symmetric silo and mirror it")]
RecordsFlag = Annotated[int, typer.Option(help="rows of forces.csv in one period of the column, 4 to 100")]
ExplainFlag = Annotated[
    bool, typer.Option("--explain", help="print which parts of the method the scene uses, and why, and stop")
]
MethodFlags = dict  # a scenario's parameter of this type stands for the flags below, and gets the values of Variant
METHOD_FLAGS = {
    "transfer": (str, "flip", "grid to points: " + " | ".join(TRANSFERS)),
    "pic_share": (float, 0.05, "of PIC in each step, with --transfer blend [-]"),
    "stress_update": (str, "last", "last | first | modified (last, from velocities sent to the nodes once more)"),
    "filter": (str, "none", "of the stresses: none | null-space (a projection) | smoothing (what the authors used)"),
    "time_step": (str, "auto", "auto, from the sand's own stiffness, or seconds"),
    "cfl": (float | None, None, "time step over h / (c + |v|) [-]; the shape's own limit if not given"),
    "mass_scaling": (float, 1.0, "factor of inertia, not of weight [-]: fewer steps, a faster flow in effect"),
}


def with_method_flags(function: Callable) -> Callable:
    """The function with its parameter of type MethodFlags, if it has one, spread into METHOD_FLAGS."""
    signature = inspect.signature(function)
    name = next((p.name for p in signature.parameters.values() if p.annotation is MethodFlags), None)
    if name is None:
        return function
    only = inspect.Parameter.KEYWORD_ONLY
    flags = [
        inspect.Parameter(flag, only, default=default, annotation=Annotated[kind, typer.Option(help=words)])
        for flag, (kind, default, words) in METHOD_FLAGS.items()
    ]
    others = [p.replace(kind=only) for p in signature.parameters.values() if p.name != name]

    @functools.wraps(function)
    def spread(**values):
        method = {flag: values.pop(flag) for flag in METHOD_FLAGS}
        method["stress_filter"] = method.pop("filter")
        method["time_step_s"] = _seconds(method.pop("time_step"))
        return function(**values, **{name: method})

    spread.__signature__ = signature.replace(parameters=others + flags)
    spread.__annotations__ = {p.name: p.annotation for p in others + flags}
    return spread


def _seconds(word: str) -> float | None:
    if word == "auto":
        return None
    try:
        return float(word)
    except ValueError as error:
        raise BadInput(f"time step is {word}; it must be auto, or a number of seconds above 0") from error


def command(function: Callable) -> None:
    """Run a function as a command line: bad input ends with exit code 2, a failed run with 1.

    The function's parameters, typer options, are the flags; an unknown flag is refused with the nearest known one.
    """
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    app.command()(with_method_flags(function))
    try:
        code = app(standalone_mode=False) or 0
        if code == STOPPED:  # typer's own answer to Ctrl-C
            raise KeyboardInterrupt
        sys.exit(code)
    except typer.BadParameter as error:
        _stop(_bad_flag(error), BAD_INPUT)
    except typer.BadParameter.__base__ as error:  # an unknown flag, a flag without its value
        _stop(error.format_message().rstrip("."), BAD_INPUT)
    except typer.Abort:
        _stop("stopped; everything up to then is kept", STOPPED)
    except ValidationError as error:
        _stop(one_sentence(error), BAD_INPUT)
    except BadInput as error:
        _stop(str(error), BAD_INPUT)
    except RunFailed as error:
        _stop(f"the run went wrong {error}; everything up to then is kept", FAILED)
    except KeyboardInterrupt:
        _stop("stopped; everything up to then is kept", STOPPED)


def _bad_flag(error: typer.BadParameter) -> str:
    flag = error.param.opts[0] if error.param is not None else "a flag"
    if not flag.startswith("-"):  # an argument: the message names its value
        message = error.message.removeprefix("Value error, ").rstrip(".")
        return f"{flag}: {message or 'not given; see --help'}"
    words = " ".join(sys.argv).replace(f"{flag}=", f"{flag} ").split()
    given = words[words.index(flag) + 1] if flag in words[:-1] else "not given"
    message = error.message.removeprefix("Value error, ")
    return f"{flag} is {given}; {message[:1].lower()}{message[1:].rstrip('.')}"


def _stop(sentence: str, code: int) -> None:
    print(f"Error: {sentence}.", file=sys.stderr)
    sys.exit(code)


def explain(scene: Scene) -> None:
    """Say which parts of the method a scene uses, and why."""
    scene.machine.start()
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in ("part", "choice", "because", "overruled by"):
        table.add_column(column)
    for part in parts(scene):
        table.add_row(part.part, part.choice, part.because, part.flag or "–")
    Console(width=None if sys.stdout.isatty() else 132, highlight=False).print(table)


def tell(folder: Path) -> None:
    """Say where to look."""
    console = Console()
    console.print(f"\nThe run is in {folder}", highlight=False, soft_wrap=True)
    for name, what in (
        ("void_ratio.mp4", "film"), ("figures/forces.png", "P, T, N against the bottom displacement"),
        ("figures/void_ratio.png", "shear zones"), ("forces.csv", "force histories"),
        ("summary.json", "peaks, residuals, certificate"), ("snapshots/silo.pvd", "for ParaView"),
    ):  # fmt: skip
        if (folder / name).exists():
            console.print(f"  {name:26s} {what}", highlight=False)
