"""Flags that scenarios share, and groups of them: a parameter of a group's type stands for all of its flags."""

import functools
import inspect
from collections.abc import Callable
from typing import Annotated, NamedTuple

import typer

from taichi_silo.errors import BadInput
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import TRANSFERS

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
ExplainFlag = Annotated[
    bool, typer.Option("--explain", help="print which parts of the method the scene uses, and why, and stop")
]
WidthFlag = Annotated[float, typer.Option(help="of the silo, or its diameter [m]")]
HeightFlag = Annotated[float, typer.Option(help="of the fill above the floor, or the outlet of a hopper [m]")]
SectionFlag = Annotated[
    str, typer.Option(help="plane | round: between parallel walls, or in a cylinder; a hopper is a wedge, or a cone")
]
OutletFlag = Annotated[float, typer.Option(help="width of the outlet [m]; its edges in a flat floor lie on the grid")]
PositionFlag = Annotated[str, typer.Option(help="centre | left | right: in the middle, or beside a wall")]
MethodFlags = dict  # what a scenario gets for its parameter of this type: the values of MethodOptions
METHOD_FLAGS = {
    "transfer": (str, "flip", "grid to points: " + " | ".join(TRANSFERS)),
    "pic_share": (float, 0.05, "of PIC in each step, with --transfer blend [-]"),
    "stress_update": (str, "last", "last | first | modified (last, from velocities sent to the nodes once more)"),
    "filter": (str, "none", "of the stresses: none | null-space (a projection) | smoothing (what the authors used)"),
    "time_step": (str, "auto", "auto, from the sand's own stiffness, or seconds"),
    "cfl": (float | None, None, "time step over h / (c + |v|) [-]; the shape's own limit if not given"),
    "mass_scaling": (float, 1.0, "factor of inertia, not of weight [-]: fewer steps, a faster flow in effect"),
}


class Group(NamedTuple):
    """Flags (kind, default, help) by name, and what makes one value of theirs."""

    flags: dict[str, tuple]
    build: Callable[[dict], object]


def method(values: dict) -> dict:
    """The values of MethodOptions, from those of METHOD_FLAGS."""
    found = {name: values[name] for name in METHOD_FLAGS}
    found["stress_filter"] = found.pop("filter")
    found["time_step_s"] = _seconds(found.pop("time_step"))
    return found


GROUPS = {MethodFlags: Group(METHOD_FLAGS, method)}


def with_groups(function: Callable) -> Callable:
    """The function, each parameter of which that has the type of a group spread into its flags."""
    signature = inspect.signature(function)
    groups = {p.name: GROUPS[p.annotation] for p in signature.parameters.values() if p.annotation in GROUPS}
    if not groups:
        return function
    only = inspect.Parameter.KEYWORD_ONLY
    flags = [
        inspect.Parameter(flag, only, default=default, annotation=_annotation(kind, words))
        for group in groups.values()
        for flag, (kind, default, words) in group.flags.items()
    ]
    others = [p.replace(kind=only) for p in signature.parameters.values() if p.name not in groups]

    @functools.wraps(function)
    def spread(**values):
        own = {p.name: values[p.name] for p in others}
        return function(**own, **{name: group.build(values) for name, group in groups.items()})

    spread.__signature__ = signature.replace(parameters=others + flags)
    spread.__annotations__ = {p.name: p.annotation for p in others + flags}
    return spread


def _annotation(kind, words):
    """Of a flag: its kind, with its help, or a tuple of its names and its help; a kind with a help of its own."""
    if not words:
        return kind
    if isinstance(words, str):
        return Annotated[kind, typer.Option(help=words)]
    *names, text = words
    return Annotated[kind, typer.Option(*names, help=text)]


def _seconds(word: str) -> float | None:
    if word == "auto":
        return None
    try:
        return float(word)
    except ValueError as error:
        raise BadInput(f"time step is {word}; it must be auto, or a number of seconds above 0") from error
