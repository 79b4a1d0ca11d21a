"""`taichi-silo render`."""

from functools import partial
from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console


def command(
    folder: Annotated[Path, Argument(help="of a run, also of one that goes on")],
    field: Annotated[
        str, Option(help="void_ratio | strain_path | speed | mean_stress | mobilised_friction | layers")
    ] = "void_ratio",
    limits: Annotated[
        str | None, Option("--range", help="LOW,HIGH: ends of the colours; from the scene and the data if not given")
    ] = None,
    colours: Annotated[
        str | None, Option(help="viridis | cividis | plasma | inferno | magma | gray | coolwarm | PuOr | BrBG")
    ] = None,
    layout: Annotated[
        str | None, Option(help="16:9 | 9:16 | 1:1 | sand: form of the page, or sand alone; 16:9 if no size is given")
    ] = None,
    size: Annotated[
        str | None, Option(help="columns x rows of a frame, such as 1280x720; even numbers; 1920x1080 if not given")
    ] = None,
    axes: Annotated[bool, Option("--axes/--no-axes", help="draw axes at the sand")] = True,
    zoom: Annotated[str | None, Option(help="LEFT,BOTTOM,RIGHT,TOP in mm: show this part of the silo")] = None,
    title: Annotated[str | None, Option(help="of your own; sand, walls and silo if not given")] = None,
    transparent: Annotated[bool, Option("--transparent", help="pictures without a background: PNG")] = False,
    beside: Annotated[
        Path | None, Option(help="folder of a second run, shown beside it with one clock: time since the flow began")
    ] = None,
    seconds: Annotated[float | None, Option(help="length of the film in seconds; 15 if no speed is given")] = None,
    speed: Annotated[
        float | None, Option(help="of the sand over its own, 0.5 for slow motion, in place of a length")
    ] = None,
    slow: Annotated[
        str | None,
        Option(help="FROM,TO,TIMES: show this part of the flow so many times slower; in mm, with a clock in s"),
    ] = None,
    fps: Annotated[int | None, Option(help="frames a second, 1 to 120; 30 if not given, of a GIF 25")] = None,
    frame: Annotated[
        float | None,
        Option(
            help="draw one picture, at this displacement in mm; in free outflow, or with --beside, so many seconds "
            "after the begin"
        ),
    ] = None,
    output: Annotated[
        Path | None,
        Option(
            help=".mp4, .webm, .gif, a name without ending for a folder of PNG; with --frame .png or .svg; "
            "FOLDER/FIELD.mp4 if not given"
        ),
    ] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a film or picture that is there")] = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Draw a film of any field of a run, afterwards: from the states that it has kept and its forces, on no screen.

    Between two states points move on straight lines. Examples:

    taichi-silo render outputs/silo --field layers --size 1280x720 --seconds 10

    taichi-silo render outputs/silo --field speed --range 0,5 --speed 0.5

    taichi-silo render outputs/silo --field mean_stress --frame 10

    taichi-silo render outputs/silo --layout 9:16 --output story.mp4

    taichi-silo render outputs/silo --layout sand --transparent --output frames

    taichi-silo render outputs/dense --beside outputs/loose --output both.mp4
    """
    from taichi_silo.show.film.render import render

    console = Console(quiet, json)
    drawn = render(
        folder, output, field=field, limits=_numbers(limits, ","), colours=colours, layout=layout, size=_size(size),
        axes=axes, zoom_mm=_numbers(zoom, ","), title=title, transparent=transparent, beside=beside, seconds=seconds,
        speed=speed, slow=_numbers(slow, ","), fps=fps, frame=frame, overwrite=overwrite,
        tracked=partial(console.tracked, words=f"drawing {field}"),
    )  # fmt: skip
    scale = drawn.scale
    ends = "" if isinstance(scale.colours, tuple) else f", {scale.low:g} to {scale.high:g}"
    console.say(f"{drawn.file}  {scale.label}{ends}")
    if frame is None:
        found = {"film": str(drawn.file), "frames": drawn.frames, "seconds": drawn.seconds}
    else:
        found = {"picture": str(drawn.file), "snapshot": drawn.snapshot or None}
    console.result(found | {"field": field, "range": [scale.low, scale.high], "size": list(drawn.size)})


def _numbers(text: str | None, between: str) -> tuple | None:
    """The numbers of a list; its parts as they are, if one is no number: then the list is refused."""
    if text is None:
        return None
    parts = tuple(text.split(between))
    try:
        return tuple(float(part) for part in parts)
    except ValueError:
        return parts


def _size(text: str | None) -> tuple | None:
    """Columns and rows; refused later if they are none."""
    parts = None if text is None else tuple(text.lower().split("x"))
    return None if parts is None else tuple(int(part) if part.isdecimal() else part for part in parts)
